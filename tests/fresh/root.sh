# shellcheck shell=bash
# A new minimal Debian 12 in a folder, and commands in it. Sourced by `run`, `presets` and `package`, which define fail MESSAGE.
# Of this machine it gets what packages come by: their sources, certificates, and pip's settings. No other variable of
# the environment, file or program reaches it.

# ready_for_roots: what make_root and in_root need; installs debootstrap where it is missing.
ready_for_roots() {
  ((EUID == 0)) || fail "a new Debian is made by root alone"
  unshare --mount --pid --fork true 2>/dev/null ||
    fail "no mount and process namespaces can be made here (a container needs the capability SYS_ADMIN for them)"
  ! command -v debootstrap >/dev/null || return 0
  local install=(env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends
    debootstrap debian-archive-keyring)
  # Package lists that are there may be good enough; old or missing ones are fetched.
  "${install[@]}" >/dev/null 2>&1 || { apt-get update -qq && "${install[@]}" >/dev/null; } ||
    fail "the program debootstrap is needed, and apt-get could not install the package of that name"
}

# make_root DIR: a minimal Debian in DIR, which is not there yet. @return non-zero if that failed.
make_root() {
  local root=$1 sources mirror file
  sources=$(debian_sources)
  mirror=$(awk '$3 == "bookworm" { print $2; exit }' <<<"$sources")
  mkdir -p -- "$root"
  # apt needs certificates where its sources do.
  contained debootstrap --variant=minbase --include=ca-certificates bookworm "$root" ${mirror:+"$mirror"} || return
  # It is made anew if power fails meanwhile.
  echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/unsafe-io"
  [[ -z $sources ]] || printf '%s\n' "$sources" >"$root/etc/apt/sources.list"
  { apt-config dump Acquire 2>/dev/null || true; } |
    { grep -E '^Acquire::(https?|Retries|Check-Valid-Until|Check-Date|ForceIPv[46])' || true; } \
      >"$root/etc/apt/apt.conf.d/90sources"
  # Certificates that it names.
  while IFS= read -r file; do carry "$file" "$root"; done < <(
    grep -o '"/[^"]*"' "$root/etc/apt/apt.conf.d/90sources" | tr -d '"')
  carry /usr/local/share/ca-certificates "$root"
  in_root "$root" sh -c 'update-ca-certificates && apt-get clean'
}

# keep_minimal DIR: makes DIR/minimal unless it is there, by way of DIR/unfinished, which is not.
keep_minimal() {
  [[ ! -d $1/minimal ]] || return 0
  make_root "$1/unfinished" >"$1/make.log" 2>&1 || {
    tail -n 20 "$1/make.log" >&2
    fail "no Debian could be made (see above)"
  }
  mv -T -- "$1/unfinished" "$1/minimal"
}

# in_root DIR COMMAND...: runs it as the new machine's root. Network and its ports are this machine's. When it ends,
# nothing of it stays mounted or running.
in_root() {
  local root=$1 file setting surroundings=()
  shift
  for file in /etc/resolv.conf /etc/hosts /etc/pip.conf /root/.config/pip/pip.conf; do carry "$file" "$root"; done
  while IFS= read -r -d '' setting; do
    [[ $setting =~ ^(PIP_[A-Z_]*|SSL_CERT_(FILE|DIR)|REQUESTS_CA_BUNDLE|(https?|no|HTTPS?|NO)_(proxy|PROXY))= ]] || continue
    surroundings+=("$setting")
    [[ ${setting#*=} != /* ]] || carry "${setting#*=}" "$root"
  done </proc/$$/environ
  contained bash -c "$ENTER" bash "$root" \
    env -i "${surroundings[@]}" HOME=/root TERM="${TERM:-dumb}" \
    PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@"
}

# remove_root DIR: ends what in_root still runs, then removes DIR.
remove_root() {
  stop_running
  rm -rf --one-file-system -- "$1"
}

stop_running() {
  local first=
  [[ -n $running ]] || return 0
  # The first process of its namespace: all others end with it, and only then does its parent, whom we wait for.
  read -r first _ <"/proc/$running/task/$running/children" || true
  kill -KILL "${first:-$running}" 2>/dev/null || true
  wait "$running" || true
  running=
}

# --- What these are made of ---------------------------------------------------------------------

# debian_sources: this machine's own sources of Debian 12, as a sources.list; nothing, where it has none.
debian_sources() {
  { apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 2>/dev/null || true; } |
    awk '$2 ~ /\/debian(-security)?\/*$/ && $3 ~ /^bookworm(-updates|-security)?$/ && $4 == "main"' | sort -u
}

# carry PATH DIR: copies a file or folder of this machine, if it is there, to the same place of the root.
carry() {
  [[ -e $1 ]] || return 0
  mkdir -p -- "$2$(dirname "$1")"
  # Links of the root that name whole paths would lead to files of this machine.
  cp -rLT --remove-destination -- "$1" "$2$1"
}

# contained PROGRAM ARGUMENT...: runs it in namespaces of its own, so that signals to this script take effect at once.
contained() {
  local status=0
  # bash starts what runs beside it with interrupts ignored, and tests send interrupts.
  env --default-signal=INT,QUIT unshare --mount --propagation private --pid --fork --kill-child "$@" &
  running=$!
  wait "$running" || status=$?
  running=
  return "$status"
}
running= # process id of what contained() waits for

# ENTER DIR COMMAND...: the root becomes a mount of its own, as the / of a machine is, with what lies below it. Of the
# devices it gets those that every machine has.
readonly ENTER='
  set -eu
  root=$1
  shift
  mount --bind "$root" "$root"
  mount -t proc proc "$root/proc"
  mount --rbind /sys "$root/sys"
  mount -t tmpfs -o mode=755 dev "$root/dev"
  mkdir "$root/dev/pts" "$root/dev/shm" "$root/dev/net"
  for device in null zero full random urandom tty net/tun; do
    [[ -e /dev/$device ]] || continue
    touch "$root/dev/$device"
    mount --bind "/dev/$device" "$root/dev/$device"
  done
  mount -t devpts -o newinstance,ptmxmode=666 devpts "$root/dev/pts"
  mount -t tmpfs -o mode=1777 shm "$root/dev/shm"
  ln -s pts/ptmx "$root/dev/ptmx"
  ln -s /proc/self/fd "$root/dev/fd"
  ln -s /proc/self/fd/0 "$root/dev/stdin"
  ln -s /proc/self/fd/1 "$root/dev/stdout"
  ln -s /proc/self/fd/2 "$root/dev/stderr"
  chroot "$root" "$@" </dev/null
  exit $?  # not by exec: process 1 stays a shell, which takes orphans in
'
