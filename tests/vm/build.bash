# Sourced by run: the programs that run in the guest. They are linked statically, so that the guest needs none of our libraries.

triple=$arch-unknown-linux-gnu

build() {
    [ "$arch" = "$(uname -m)" ] || use_cross_tools
    say "building for $triple"
    tools/libclang "$target/build.env"
    # shellcheck disable=SC1091
    source "$target/build.env"
    [ -z "$features" ] || skip "the crate v4l cannot be built without libclang"
    local variable=CARGO_TARGET_${triple^^}_RUSTFLAGS
    export "${variable//-/_}=-C target-feature=+crt-static"
    cargo build --release --target "$triple" -p tagbus-cli -p tagbus-vm
    programs=$target/$triple/release
}

use_cross_tools() {
    skip "programs for $arch can so far only be built on such a machine, and this is $(uname -m)"
}

# The pictures, painted once for all runs; by a program for this machine.
paint() {
    local size
    for size in 640x480 1280x720; do
        "$programs/tagbus-vm" scene "$size" "$1"
    done
}
