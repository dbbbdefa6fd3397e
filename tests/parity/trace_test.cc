#include "actor/replay/trace.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "common/text/number_text.h"

namespace metronome {
namespace {

const char* const kPush = METRONOME_FIXTURES "/recordings/push-v3_s0_expert.csv.gz";

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

/// A small recording without what step() returned, to be read and damaged.
std::string PlainText() {
  std::string text =
      R"(# {"task": "push-v3", "steps": 1, "rand_vec": [0, 0.65, 0.02, 0, 0.85, 0.015],)"
      R"( "init_obs": [0)";
  for (int i = 1; i < metaworld::kObservationSize; ++i) text += ", 0";
  text += R"(], "goal": [0, 0.85, 0.0194], "internals_after_reset": {"init_tcp": [0, 0.6, 0.15],)"
          R"( "obj_init_pos": [0, 0.65, 0.0194], "_target_to_obj_init": null, "objHeight": 0.02},)"
          R"( "model_body_pos_changed": {}, "model_site_pos_changed": {"goal": [0, 0.85, 0.0194]}})"
          "\nstep";
  const std::vector<std::pair<std::string, int>> columns = {
      {"qpos", 16}, {"qvel", 15},  {"mocap_pos", 3}, {"mocap_quat", 4},
      {"ctrl", 2},  {"action", 4}, {"warm", 15}};
  std::string row = "1";
  for (const auto& [name, count] : columns)
    for (int i = 0; i < count; ++i) {
      text += "," + name + std::to_string(i);
      row += ",0.5";
    }
  return text + "\n" + row + "\n";
}

class TraceTest : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() /
            ("metronome_trace_" + std::to_string(::getpid()) + ".csv");
  }
  void TearDown() override { std::filesystem::remove(file_); }

  std::string Write(const std::string& text) const {
    std::ofstream(file_, std::ios::binary) << text;
    return file_.string();
  }

  struct Run {
    int status;
    std::string out, error;
  };
  static Run Trace(const replay::TraceOptions& options) {
    std::ostringstream out;
    testing::internal::CaptureStderr();
    const int status = replay::RunTrace(options, out);
    return {status, out.str(), testing::internal::GetCapturedStderr()};
  }

  /// `recording` is refused with exit 2, nothing printed, and a message that says `reason`.
  static void ExpectRefused(const std::string& recording, const std::string& reason) {
    const Run run = Trace({"push", recording, "free", ""});
    EXPECT_EQ(run.status, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.error.find(reason), std::string::npos) << run.error;
    EXPECT_NE(run.error.find(recording), std::string::npos) << run.error;
  }

  std::filesystem::path file_;
};

TEST_F(TraceTest, PrintsAHeaderTheResetAndARowPerStepThatReadBackExactly) {
  const Run run = Trace({"push-v2", kPush, "forced", ""});
  ASSERT_EQ(run.status, 0) << run.error;
  const auto lines = Lines(run.out);
  ASSERT_EQ(lines.size(), 152U);
  EXPECT_EQ(lines[0].substr(0, 15), "step,obs0,obs1,");
  EXPECT_EQ(lines[0].substr(lines[0].find("obs38")),
            "obs38,reward,success,near_object,grasp_success,grasp_reward,in_place_reward,"
            "obj_to_target");
  const auto reset = Fields(lines[1]);
  ASSERT_EQ(reset.size(), 47U);
  EXPECT_EQ(reset[0], "0");
  for (std::size_t i = 40; i < 47; ++i) EXPECT_EQ(reset[i], "") << i;
  const metronome::replay::Trace want =
      replay::PlayRecording(replay::ReadRecording(kPush), replay::TraceMode::kForced, "");
  for (std::size_t t = 1; t <= 150; ++t) {
    const auto fields = Fields(lines[t + 1]);
    ASSERT_EQ(fields.size(), 47U);
    EXPECT_EQ(fields[0], std::to_string(t));
    for (int i = 0; i < metaworld::kObservationSize; ++i)
      ASSERT_EQ(text::ParseNumber<double>(fields[i + 1]), want.steps[t - 1]->observation[i]);
    ASSERT_EQ(text::ParseNumber<double>(fields[40]), want.steps[t - 1]->reward);
  }
}

TEST_F(TraceTest, ReadsPlainFilesAndThoseWithoutWhatStepReturned) {
  const Run run = Trace({"push", Write(PlainText()), "forced", ""});
  EXPECT_EQ(run.status, 0) << run.error;
  EXPECT_EQ(Lines(run.out).size(), 3U);
}

TEST_F(TraceTest, ReadsWhatEditorsOfOtherSystemsSave) {
  const std::string plain = PlainText();
  std::string saved = "\xEF\xBB\xBF";
  for (const char c : plain) saved += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const Run run = Trace({"push", Write(saved), "forced", ""});
  EXPECT_EQ(run.status, 0) << run.error;
  EXPECT_EQ(run.out, Trace({"push", Write(plain), "forced", ""}).out);
}

TEST_F(TraceTest, AMissingRecordingIsRefused) {
  ExpectRefused("/nowhere/recording.csv", "cannot be opened");
}

TEST_F(TraceTest, ARecordingCutShortIsRefusedWhereverTheCutIs) {
  std::ifstream whole(kPush, std::ios::binary);
  const std::string gzip{std::istreambuf_iterator<char>(whole), {}};
  for (const std::size_t size : {gzip.size() / 3, gzip.size() / 2, gzip.size() - 9})
    ExpectRefused(Write(gzip.substr(0, size)), "recording");
  const std::string plain = PlainText();
  for (std::size_t size = 0; size < plain.size() - 4; size += 13)
    ExpectRefused(Write(plain.substr(0, size)), "recording");
}

TEST_F(TraceTest, ANumberThatIsNoneIsNamedByRowAndColumn) {
  std::string text = PlainText();
  text.replace(text.rfind("0.5"), 3, "abc");
  ExpectRefused(Write(text), "row 1, column warm14: \"abc\" is not a number");
}

TEST_F(TraceTest, AMissingKeyOrColumnIsNamed) {
  std::string text = PlainText();
  text.replace(text.find("rand_vec"), 8, "rand_vac");
  ExpectRefused(Write(text), "rand_vec");
  text = PlainText();
  text.replace(text.find("action2"), 7, "acton2x");
  ExpectRefused(Write(text), "action2");
}

TEST_F(TraceTest, AStateOfAnotherSceneIsRefused) {
  std::string text = PlainText();
  text.replace(text.find("qpos15"), 6, "other5");
  const Run run = Trace({"push", Write(text), "forced", ""});
  EXPECT_EQ(run.status, 2);
  EXPECT_EQ(run.out, "");
  EXPECT_NE(run.error.find("recorded qpos has 15 numbers, the scene needs 16"), std::string::npos)
      << run.error;
}

TEST_F(TraceTest, ABodyOrSiteThatTheSceneLacksIsNamed) {
  const auto refusal = [this](const std::string& before, const std::string& after) {
    std::string text = PlainText();
    text.replace(text.find(before), before.size(), after);
    const Run run = Trace({"push", Write(text), "forced", ""});
    EXPECT_EQ(run.status, 2);
    EXPECT_EQ(run.out, "");
    return run.error;
  };
  const std::string body = refusal("pos_changed\": {}", "pos_changed\": {\"nobody\": [0, 0, 0]}");
  EXPECT_NE(body.find("recorded body \"nobody\" is not in the scene"), std::string::npos) << body;
  const std::string site = refusal("\"goal\": [0, 0.85, 0.0194]}}", "\"gaol\": [0, 0, 0]}}");
  EXPECT_NE(site.find("recorded site \"gaol\" is not in the scene"), std::string::npos) << site;
}

TEST_F(TraceTest, ARecordingOfAnotherTaskIsRefused) {
  const Run run = Trace({"assembly", kPush, "free", ""});
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.error.find("is of task push-v3, not assembly"), std::string::npos) << run.error;
}

TEST_F(TraceTest, UnknownModesAndTasksAreRefused) {
  EXPECT_EQ(Trace({"push", kPush, "loose", ""}).status, 2);
  const Run run = Trace({"pussh", kPush, "free", ""});
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.error.find("did you mean \"push\""), std::string::npos) << run.error;
}

TEST_F(TraceTest, MissingScenesAreAnErrorOfTheSetUp) {
  const Run run = Trace({"push", kPush, "free", "/nowhere"});
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.error.find("deploy/setup"), std::string::npos) << run.error;
}

}  // namespace
}  // namespace metronome
