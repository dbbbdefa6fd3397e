#pragma once

#include <fastdds/rtps/attributes/PropertyPolicy.h>

#include <string>

#include "common/messages/bus_options.h"

/// Taking part in a run whose participants deploy/security gave identities: DDS-Security with the
/// files of one folder.
namespace metronome::dds::security {

/// Judges an identity before Fast DDS does, which only logs and then fails. Does nothing if
/// `options.security` is empty.
/// @param role  "learner", "actor" or "observer": what the identity must be for.
/// @throws std::invalid_argument that names the file, what is wrong with it and the remedy: one is
///         missing or unreadable, expired, revoked, not signed by its authority, or of another
///         key, run, domain or role.
void CheckIdentity(const BusOptions& options, const std::string& role);

/// Authentication, access control and encryption by the identity in `folder`.
void AddSecurity(const std::string& folder, eprosima::fastrtps::rtps::PropertyPolicy* properties);

}  // namespace metronome::dds::security
