# Sourced by run: the programs that run in the guest. They are linked statically, so that the guest needs none of our libraries.

triple=$arch-unknown-linux-gnu

build() {
    say "building for $triple"
    tools/libclang "$target/build.env"
    # shellcheck disable=SC1091
    source "$target/build.env"
    [ -z "$features" ] || skip "the crate v4l cannot be built without libclang"
    if [ "$arch" = "$(uname -m)" ]; then build_here; else build_crosswise; fi
}

build_here() {
    local variable=CARGO_TARGET_${triple^^}_RUSTFLAGS
    export "${variable//-/_}=-C target-feature=+crt-static"
    cargo build --release --target "$triple" -p tagbus-cli -p tagbus-vm
    programs=$target/$triple/release
    strip_program=(strip) run_program=()
}

# With the compiler, linker and emulator of tests/aarch64; on its own, because those scripts change what cargo does.
build_crosswise() {
    (
        source tests/aarch64/tools.bash
        need_tools
        use_tools
        export BINDGEN_EXTRA_CLANG_ARGS_aarch64_unknown_linux_gnu="--sysroot=$root -isystem $root/usr/aarch64-linux-gnu/include"
        CARGO_ENCODED_RUSTFLAGS+=$(printf '\x1f-Ctarget-feature=+crt-static')
        say "building with $(with_tools "$RUSTC" --version)"
        with_tools cargo build --release --target "$triple" -p tagbus-cli -p tagbus-vm
    ) || exit $?
    programs=$target/aarch64/build/$triple/release
    # For the host: to look at programs of the other kind, and to run them.
    local root=$target/aarch64/root
    strip_program=(env "LD_LIBRARY_PATH=$root/usr/lib/x86_64-linux-gnu" "$root/usr/bin/aarch64-linux-gnu-strip")
    run_program=("$root/usr/bin/qemu-aarch64-static")
}

# The pictures and what is to be found in them, painted once for each state of the program that paints them.
paint() {
    local size painted=$cache/pictures-$arch
    if [ ! "$painted/complete" -nt "$programs/tagbus-vm" ]; then
        rm -rf "$painted"
        for size in 640x480 1280x720; do
            "${run_program[@]}" "$programs/tagbus-vm" scene "$size" "$painted"
        done
        touch "$painted/complete"
    fi
    mkdir -p "$1" && cp "$painted"/*.* "$1"
}
