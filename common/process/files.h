#pragma once

#include <string>
#include <string_view>

/// Files that are whole or not there at all. No function keeps state; thread-safe on distinct
/// paths. Every error is a std::system_error whose what() names the path.
namespace metronome::process {

/// The whole content of a file. @throws std::system_error if it cannot be read (a folder, say).
std::string ReadFile(const std::string& path);

/// The file that writing to `path` replaces: `path` itself, or where a symbolic link leads, so that
/// the link stays. A link that leads nowhere is itself replaced.
/// @throws std::system_error if something is there that is no regular file (a device, a pipe, a
///         folder): a new file must not take its place.
std::string FileToReplace(const std::string& path);

/// Writes `content` to FileToReplace(path) so that, whatever happens, it holds the old content or
/// the new: a new file in the same folder is written, synced and put in its place, then the folder
/// is synced. The new file has no name before it is whole, so that a process that is ended leaves
/// nothing; only where the file system knows no such files (NFS) it is FILE.tmp.PID meanwhile.
/// @throws std::system_error (disk full, no folder); the old content stays and the temporary is
///         gone. If only the folder could not be synced, the new content is in place already, but
///         may not outlive a power cut.
void WriteFileAtomically(const std::string& path, std::string_view content);

/// Points the symbolic link at `target` (relative to the link's folder), replacing an older link
/// in one step. @throws std::system_error; an older link stays.
void ReplaceSymlink(const std::string& link, const std::string& target);

}  // namespace metronome::process
