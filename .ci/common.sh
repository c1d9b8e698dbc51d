# What .ci/run and .ci/full share; read by `source`, from the root of the repository.
export CI=1 # hypothesis repeats its examples
export PIP_CONSTRAINT="$PWD/constraints.txt" UV_CONSTRAINT="$PWD/constraints.txt" # the tested versions
export AMB_COSIM_TEST_CACHE="${XDG_CACHE_HOME:-$HOME/.cache}/amb-cosim-tests"
export MYPY_CACHE_DIR="$AMB_COSIM_TEST_CACHE/mypy" # of any clone: files are compared by content
export PATH="$PATH:/usr/lib/wine" # Debian's wine64 is not on the PATH

stage() { # prints the time since the start before the name of a stage
  printf '\n== %d:%02d %s\n' $((SECONDS / 60)) $((SECONDS % 60)) "$1"
}

readme_command() { # the command below the marker <!-- command: NAME -->
  grep -A 3 -F "<!-- command: $1 -->" README.md | sed -n '3p'
}

apt_install() { # fails where there is no apt
  command -v apt-get >/dev/null || return 1
  [ -n "${apt_is_updated:-}" ] || { apt-get update -q >/dev/null && apt_is_updated=1; }
  apt-get install -qy --no-install-recommends "$@" >/dev/null
}

command -v git >/dev/null || apt_install git
if ! python3 -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
  apt_install python3 python3-venv
fi
