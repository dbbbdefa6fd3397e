# What prepares this checkout writes into it, one at a time. Sourced; the caller's folder is the checkout, and it
# defines die MESSAGE.

# Streams that are closed lead nowhere, so that nothing that is opened later takes their place: a pipe whose reader holds
# its other end never ends.
for stream in 0 1 2; do
  [[ -e /proc/self/fd/$stream ]] || eval "exec $stream<>/dev/null"
done

# writable PATH: whether it can be written, or made where it is not there.
writable() {
  local path=$1
  while [[ ! -e $path && ! -L $path ]]; do path=$(dirname -- "$path"); done
  [[ -w $path ]]
}

# require_writable REMEDY PATH...: ends this process unless all can be written.
require_writable() {
  local remedy=$1 path
  shift
  for path; do
    writable "$path" || die "this needs to write to $PWD/$path, which $(id -un) cannot (it is another user's, or read-only).
$remedy"
  done
}

# lock FILE [WORDS]: waits until nobody else holds FILE, after saying WORDS, and holds it until this process ends.
lock() {
  mkdir -p -- "$(dirname -- "$1")"
  exec {lock_file}>>"$1"
  flock -n "$lock_file" || { [[ -z ${2-} ]] || say "$2"; flock "$lock_file"; }
}
