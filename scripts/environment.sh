# The project's own Python environment, .venv. Read by scripts/demo and scripts/test, which set `root` first:
#   environment requirements.lock    makes .venv where it is missing or out of date, with what that lock file lists
# Nothing outside the project's folder is changed. PYTHON=/path/to/python chooses another Python than the first that fits.

say() { printf '%s\n' "$@" >&2; }
fail() { say "$@"; exit 1; }

fits() { command -v "$1" >/dev/null 2>&1 && "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }
makes_venvs() { "$1" -c 'import ensurepip, venv' >/dev/null 2>&1; }

# Sets `python`: the first that fits and can make an environment; failing that, the first that fits.
find_python() {
  python=
  for candidate in ${PYTHON:-python3.13 python3.12 python3.11 python3 python3.14 python}; do
    fits "$candidate" || continue
    makes_venvs "$candidate" && { python=$candidate; return; }
    [ -n "$python" ] || python=$candidate
  done
}

explain_no_python() {
  fail "ecume needs Python 3.11 or newer${PYTHON:+, and $PYTHON is not}; none was found." \
    "  Debian, Ubuntu:  sudo apt install python3 python3-venv" \
    "  Fedora:          sudo dnf install python3" \
    "  macOS:           brew install python" \
    "  anywhere:        install uv, which brings a Python of its own" \
    "Then run this script again. To choose a Python yourself: PYTHON=/path/to/python3 sh scripts/demo"
}

explain_no_venv() {
  version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
  fail "$python (Python $version) comes without the parts that make an environment (venv and ensurepip)." \
    "  Debian, Ubuntu:  sudo apt install python$version-venv" \
    "  anywhere:        install uv, which makes environments by itself" \
    "Then run this script again. To choose another Python: PYTHON=/path/to/python3 sh scripts/demo"
}

# An environment serves as long as the locks, the package's metadata and the Python stay what they were.
key() {
  "$1" - "$root" <<'PYTHON'
import hashlib, pathlib, sys
files = ("requirements.lock", "requirements-test.lock", "pyproject.toml", "scripts/environment.sh")
text = b"\0".join(pathlib.Path(sys.argv[1], name).read_bytes() for name in files)
print(hashlib.sha256(text + sys.version.encode() + sys.argv[1].encode()).hexdigest())
PYTHON
}

# Windows keeps an environment's programs in Scripts, everything else in bin.
find_bin() { bin=$venv/bin; [ ! -d "$venv/Scripts" ] || bin=$venv/Scripts; }

# An environment made for the other lock of the same day is kept and only added to.
kept() { [ "$(cat "$venv/made-for-requirements.lock" 2>/dev/null)" = "$(key "$bin/python" 2>/dev/null || echo none)" ]; }

make_with_uv() {
  command -v uv >/dev/null 2>&1 || return 1
  kept || { rm -rf "$venv" && uv venv $quiet --python "${python:->=3.11}" "$venv"; }
  find_bin
  uv pip install $quiet --python "$bin/python" --require-hashes --no-deps -r "$root/$1" &&
    uv pip install $quiet --python "$bin/python" --no-deps --no-build-isolation -e "$root"
}

make_with_pip() {
  ! command -v uv >/dev/null 2>&1 || say "uv could not; trying pip ..."
  [ -n "$python" ] || explain_no_python
  makes_venvs "$python" || explain_no_venv
  { kept && "$bin/python" -m pip --version >/dev/null 2>&1; } || "$python" -m venv --clear "$venv"
  find_bin
  # Bytecode is left to the first import: most of what SciPy and Matplotlib bring is never imported.
  set -- "$1" --disable-pip-version-check --no-input --no-compile --no-deps $quiet
  lock=$1
  shift
  "$bin/python" -m pip install "$@" --require-hashes -r "$root/$lock" &&
    "$bin/python" -m pip install "$@" --no-build-isolation -e "$root"
}

# The test lock holds all that the demo's does, so an environment made for the tests serves the demo as well.
up_to_date() {
  [ -x "$bin/python" ] || [ -x "$bin/python.exe" ] || return 1
  now=$(key "$bin/python" 2>/dev/null) || return 1
  [ "$(cat "$venv/made-for-$1" 2>/dev/null)" = "$now" ] || [ "$(cat "$venv/made-for-requirements-test.lock" 2>/dev/null)" = "$now" ]
}

environment() {
  venv=$root/.venv
  # Without bytecode each process would parse all its libraries again. Where none is wanted beside sources, it is kept here.
  if [ -n "${PYTHONDONTWRITEBYTECODE:-}" ]; then
    unset PYTHONDONTWRITEBYTECODE
    export PYTHONPYCACHEPREFIX="$venv/bytecode"
  fi
  find_bin
  up_to_date "$1" && return
  find_python
  quiet=-q
  [ ! -t 2 ] || quiet=
  say "Setting up ${venv#"$root"/} from $1 (once; half a minute, more on a slow line) ..."
  make_with_uv "$1" || make_with_pip "$1" || fail "The environment could not be made: see the message above."
  key "$bin/python" > "$venv/made-for-$1"
}
