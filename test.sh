#!/usr/bin/env bash
# Checks everything: formatting, lints, unit, doc and end-to-end tests, documentation, and the
# Python validation in its own virtual environment. Needs Rust, Python 3.11 with venv, and the
# package registries of both. Stops at the first failure.
set -euo pipefail
cd "$(dirname "$0")"

step() {
    printf '\n== %s\n' "$*"
    if ! "$@"; then
        printf '\ntest.sh: failed: %s\n' "$*" >&2
        exit 1
    fi
}

for tool in cargo python3; do
    if ! command -v "$tool" >/dev/null; then
        printf "test.sh: '%s' is missing, expected it in PATH\n" "$tool" >&2
        exit 2
    fi
done
if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
    printf 'test.sh: python3 has no venv; on Debian: apt-get install python3-venv\n' >&2
    exit 2
fi

# first, since tests and renders need the mesh
step python3 scenes/make_meshes.py
step cargo fmt --all --check
step cargo clippy --workspace --all-targets --quiet -- -D warnings
step cargo test --workspace --quiet
step env RUSTDOCFLAGS=-Dwarnings cargo doc --workspace --no-deps --quiet
step python3 validation/run.py
printf '\ntest.sh: all checks passed\n'
