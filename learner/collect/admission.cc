#include "learner/collect/admission.h"

#include <cstddef>
#include <utility>

namespace metronome::collect {
namespace {

// Both builds and what they differ in must fit into a refusal (idl/metronome.idl).
constexpr std::size_t kMaxBuildShown = 500;

// A checkpoint of an older build holds the first of the two SHA-256 alone
// (actor/play/canonical_episode.h). Nothing longer than both: it would turn all others away.
bool Completes(const std::string& digest, const std::string& older) {
  constexpr std::size_t kSha256 = 64;  // hex digits
  return older.size() == kSha256 && digest.size() == 2 * kSha256 && digest.starts_with(older);
}

}  // namespace

std::string ShownBuild(const std::string& build) {
  return build.size() <= kMaxBuildShown ? build : build.substr(0, kMaxBuildShown) + "...";
}

Admission::Admission(const RunDescription& description, std::string digest)
    : incarnation_(description.incarnation),
      engine_(description.engine),
      digest_(std::move(digest)),
      digest_from_("the actors of this run before it was resumed") {}

Admission::Decision Admission::Judge(const ActorStatus& status) {
  if (status.protocol_version != kProtocolVersion) {
    return {Verdict::kRefuse, "it speaks protocol version " +
                                  std::to_string(status.protocol_version) + ", the learner " +
                                  std::to_string(kProtocolVersion) +
                                  ": build both from the same sources"};
  }
  if (status.incarnation != incarnation_) return {};
  if (status.engine != engine_) {
    return {Verdict::kRefuse, "the run's engine is " + engine_ + ", the actor's on " + status.host +
                                  " is " + status.engine +
                                  ": start an actor that was built against " + engine_};
  }
  if (status.envs == 0) return {Verdict::kRefuse, "it offers no env"};
  if (status.canonical_digest.empty()) return {};
  if (digest_.empty()) {
    digest_ = status.canonical_digest;
    digest_from_ = "the first actor, on " + status.host + " (" + ShownBuild(status.build) + ")";
  }
  if (Completes(status.canonical_digest, digest_)) digest_ = status.canonical_digest;
  if (digest_ != status.canonical_digest) return {Verdict::kRefuse, DigestComplaint(status)};
  return {Verdict::kAdmit, {}};
}

std::string Admission::DigestComplaint(const ActorStatus& status) const {
  return "the actor on " + status.host + " (" + ShownBuild(status.build) +
         ") computes other numbers than the run so far: its canonical episode has digest " +
         status.canonical_digest + ", that of " + digest_from_ + " has " + digest_ +
         "; it needs the same version of Metronome, SLEEF and the C library as the others, and a "
         "processor with FMA if theirs have it";
}

}  // namespace metronome::collect
