# Sourced by the scripts of this folder: compiler, standard library, linker and emulator for aarch64.
#
# They are Debian's packages, unpacked (1.8 GB) under target/aarch64 and left alone from then on; neither root nor an
# installation is needed. Cargo is the usual one, but the compiler has to be Debian's: a standard library serves only
# the compiler that it was built with.

export PATH="$PATH:${HOME:-/root}/.cargo/bin"

target=${CARGO_TARGET_DIR:-target}
private=$(mkdir -p "$target/aarch64" && cd "$target/aarch64" && pwd)
root=$private/root
triple=aarch64-unknown-linux-gnu
# Tests run in the static emulator, which needs none of the libraries around it. Only the other one takes plugins.
packages=(rustc-web libstd-rust-web-dev:arm64 gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static qemu-user)

# They come from the lists of this very system, so its C library serves them, and a second one would only get in the way of
# their programs.
unwanted=libc6_*_amd64.deb

source tests/words.bash
source tests/debian.bash

# Only for the commands below: the compiler's libraries lie in the private folder.
with_tools() {
    LD_LIBRARY_PATH=$root/usr/lib/x86_64-linux-gnu:$root/lib/x86_64-linux-gnu "$@"
}

need_tools() {
    [ "$(uname -m)" != aarch64 ] || skip "this machine runs it without emulation"
    [ "$(uname -m)" = x86_64 ] || skip "the emulation is only prepared for x86-64 hosts, and this is $(uname -m)"
    command -v apt-get >/dev/null || skip "there is no apt-get"
    command -v cargo >/dev/null || skip "cargo is missing"
    fetch_packages "$root" "${packages[@]}" || skip "apt could not provide ${packages[*]}"
    local needed found
    needed=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
    found=$(with_tools "$root/usr/bin/rustc" --version | cut -d ' ' -f 2)
    dpkg --compare-versions "$found" ge "$needed" || skip "apt's compiler is Rust $found, and tagbus wants $needed"
}

# Cargo builds for aarch64 from here on, into a folder of its own.
use_tools() {
    export RUSTC=$root/usr/bin/rustc
    export CARGO_TARGET_DIR=$private/build
    # After the system's own programs, so that of equal names those are taken.
    export PATH=$PATH:$root/usr/bin
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=qemu-aarch64-static
    # The linker's scripts name libraries by absolute paths. Separated as cargo wants it: a path may hold a blank.
    local folder=$root/usr/aarch64-linux-gnu/lib
    CARGO_ENCODED_RUSTFLAGS=$(printf -- '-Clink-arg=%s\x1f' "--sysroot=$root" "-B$folder" "-L$folder")
    export CARGO_ENCODED_RUSTFLAGS=${CARGO_ENCODED_RUSTFLAGS%$'\x1f'}
    export QEMU_LD_PREFIX=$root/usr/aarch64-linux-gnu QEMU_UNSET_ENV=LD_LIBRARY_PATH
}
