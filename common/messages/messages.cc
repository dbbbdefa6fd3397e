#include "common/messages/messages.h"

namespace metronome {

std::string HostOfName(const std::string& name) { return name.substr(0, name.rfind(':')); }

}  // namespace metronome
