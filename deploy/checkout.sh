# For programs that prepare this checkout: they write into it one at a time. Sourced; the current folder is the checkout, and the caller
# defines say and die MESSAGE.
# shellcheck shell=bash

# Streams that are closed lead nowhere, so that nothing that is opened later takes their place: a pipe whose reader holds
# its other end never ends.
for stream in 0 1 2; do
  [[ -e /proc/self/fd/$stream ]] || eval "exec $stream<>/dev/null"
done

# unwritable PATH...: prints the first that cannot be written, or made where it is not there. @return whether there is one.
unwritable() {
  local path place
  for path; do
    place=$path
    while [[ ! -e $place && ! -L $place ]]; do place=$(dirname -- "$place"); done
    [[ -w $place ]] || { printf '%s' "$path"; return 0; }
  done
  return 1
}

# require_writable REMEDY PATH...: ends this process unless all can be written.
require_writable() {
  local remedy=$1 path
  shift
  ! path=$(unwritable "$@") ||
    die "this needs to write to $PWD/$path, which $(id -un) cannot (it is another user's, or read-only).
$remedy"
}

# lock FILE: waits until nobody else holds FILE, and holds it until this process ends.
lock() {
  mkdir -p -- "$(dirname -- "$1")"
  exec {lock_file}>>"$1"
  flock -n "$lock_file" || { say "waiting for another set-up of this checkout"; flock "$lock_file"; }
}
