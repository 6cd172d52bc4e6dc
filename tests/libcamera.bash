# Sourced by libcamera: a camera of libcamera in the virtual machine.
#
# ```text
# vimc (sensor, scaler, node) ─▶ libcamera ─ BGR, dma-buf ─▶ tagbus camera ─▶ service ─▶ watch
# ```
#
# vimc paints its own picture, without tags. libcamera has a camera that plays files, but wants a driver (udmabuf) that Debian's kernels do
# not have.

test_in_machine() {
    local arch=x86_64 cache cases='*'
    cache=$(mkdir -p "$target/vm" && cd "$target/vm" && pwd)
    source tests/vm/fetch.bash
    source tests/vm/vimc.bash
    source tests/vm/build.bash
    source tests/vm/boot.bash
    fetch_all
    make_vimc || skip "there is no vimc"
    build
    build_linked
    gather_files
    make_initramfs
    boot libcamera
}

# The program that is linked with libcamera, in a folder of its own: the machine's other programs are linked statically.
build_linked() {
    (
        use_library
        # The library wants a newer C library than the linker knows; the one that it runs with is brought.
        export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="-Clink-arg=-Wl,--allow-shlib-undefined"
        say "building tagbus with libcamera"
        cargo build --release --target "$triple" --target-dir "$target/libcamera-build" -p tagbus-cli --features libcamera
    )
}

# What the guest needs beside the usual: the program, its libraries and the library's parts.
gather_files() {
    extra_files=$target/libcamera-guest
    rm -rf "$extra_files"
    mkdir -p "$extra_files/bin" "$extra_files/linked" "$extra_files/usr/lib/x86_64-linux-gnu" "$extra_files/usr/share/libcamera"
    strip -o "$extra_files/linked/tagbus" "$target/libcamera-build/$triple/release/tagbus"
    find "$libraries" -maxdepth 1 -name '*.so.*' -exec cp -L {} "$extra_files/linked/" \;
    cp -a "$libraries/libcamera" "$extra_files/usr/lib/x86_64-linux-gnu/"
    cp -a "$root/usr/share/libcamera/ipa" "$extra_files/usr/share/libcamera/"
    cat >"$extra_files/bin/tagbus-linked" <<'SH'
#!/bin/sh
unset LD_LIBRARY_PATH
exec /linked/ld-linux-x86-64.so.2 --library-path /linked /linked/tagbus "$@"
SH
    chmod 755 "$extra_files/bin/tagbus-linked"
}
