"""The rights of each role on each topic: the table of idl/README.md as permissions of DDS-Security."""

import re

# A name is a folder and part of a certificate's subject.
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")

_PUBLISH = {
    "learner": ("run_description", "policy_snapshot", "episode_assignment", "learner_status"),
    "actor": ("episode", "actor_status"),
    "observer": (),
}
_SUBSCRIBE = {
    # Its own kind too: two learners of a run notice each other.
    "learner": ("episode", "actor_status", "run_description"),
    "actor": ("run_description", "policy_snapshot", "episode_assignment"),
    "observer": ("run_description", "learner_status"),
}

# Everything on everything. Of these Fast DDS 2.9 enforces the protection of data at the receiver;
# the others hide what its own senders send.
_GOVERNANCE = """\
<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <domain_access_rules>
    <domain_rule>
      <domains>
        <id>{domain}</id>
      </domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
"""

_PERMISSIONS = """\
<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <permissions>
    <grant name="{role}">
      <subject_name>{subject}</subject_name>
      <validity>
        <not_before>{begin:%Y-%m-%dT%H:%M:%S}</not_before>
        <not_after>{end:%Y-%m-%dT%H:%M:%S}</not_after>
      </validity>
      <allow_rule>
        <domains>
          <id>{domain}</id>
        </domains>
{topics}
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
"""

_CRITERIA = """\
        <{what}>
          <topics>
{topics}
          </topics>
          <partitions>
            <partition>{run}</partition>
          </partitions>
        </{what}>"""


def role_of(name):
    """Every name but "learner" and "observer" is an actor's."""
    return name if name in ("learner", "observer") else "actor"


def _compact(text):
    """Without indentation: permissions travel in one datagram of a limited size
    (common/dds/participant_qos.cc)."""
    return "\n".join(line.strip() for line in text.splitlines())


def governance(domain):
    return _compact(_GOVERNANCE.format(domain=domain))


def permissions(name, subject, run, domain, begin, end):
    """@param subject  of the certificate, as RFC 4514 writes it.
    @param begin, end  datetimes; each host takes them for its local time."""
    role = role_of(name)
    criteria = [
        _CRITERIA.format(
            what=what,
            run=run,
            topics="\n".join(f"            <topic>metronome/{topic}</topic>" for topic in topics),
        )
        for what, topics in (("publish", _PUBLISH[role]), ("subscribe", _SUBSCRIBE[role]))
        if topics
    ]
    return _compact(
        _PERMISSIONS.format(
            role=role,
            subject=subject,
            domain=domain,
            begin=begin,
            end=end,
            topics="\n".join(criteria),
        )
    )
