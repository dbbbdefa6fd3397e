#pragma once

namespace metronome::metaworld {

/// Switches a cheap test before MuJoCo 2.2.2's exact collision functions on or off, for every model
/// of the process: a geom whose bounding sphere lies clear of a box cannot touch that box.
/// Contacts, hence all results, are the same to the bit; 2.2.2, which compares bounding spheres
/// alone, spends up to half its time on such pairs (a table's sphere holds the whole scene). Does
/// nothing on 3.3.0, which compares boxes itself and recognises its functions by their address. Not
/// while any thread steps. Idempotent. InitialiseEngine switches it on; tests and the benchmark
/// switch it off to have the bare engine.
void SetCulling(bool on);

}  // namespace metronome::metaworld
