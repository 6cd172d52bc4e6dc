# Sourced by libcamera: plays pictures to libcamera in the virtual machine.
#
# ```text
# numbered pictures ─ JPEG ─▶ libcamera's "virtual" camera ─ NV12, dma-buf ─▶ tagbus camera ─▶ service ─▶ judge
# vimc (sensor, scaler, node) ─▶ libcamera ─ BGR ─▶ tagbus camera ─▶ watch
# ```

test_in_machine() {
    local arch=x86_64 cache cases='*'
    cache=$(mkdir -p "$target/vm" && cd "$target/vm" && pwd)
    source tests/vm/fetch.bash
    source tests/vm/vimc.bash
    source tests/vm/build.bash
    source tests/vm/boot.bash
    fetch_all
    make_vimc || skip "there is no vimc"
    fetch_packages "$target/jpeg" libjpeg-turbo-progs || skip "apt could not provide libjpeg-turbo-progs"
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

# What the guest needs beside the usual: the program, its libraries, the library's parts and the pictures.
gather_files() {
    extra_files=$target/libcamera-guest
    rm -rf "$extra_files"
    local virtual=$extra_files/usr/share/libcamera/pipeline/virtual
    mkdir -p "$extra_files/bin" "$extra_files/linked" "$extra_files/usr/lib/x86_64-linux-gnu" "$virtual"
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
    virtual_pictures "$virtual/images"
    cat >"$virtual/virtual.yaml" <<'YAML'
"Virtual0":
  supported_formats:
  - width: 640
    height: 480
    frame_rates: [30, 60]
  frames:
    path: "images"
  location: "front"
  model: "Pictures with tags"
YAML
}

# The numbered pictures as grey JPEG of the best quality; the library plays them in the order of their numbers.
virtual_pictures() {
    local into=$1 work number=0 frame=$((640 * 480)) jpeg=$target/jpeg
    work=$(mktemp -d "$cache/virtual.XXXXXX")
    mkdir -p "$into"
    paint "$work"
    while [ $((number * frame)) -lt "$(stat -c %s "$work/640x480.grey")" ]; do
        { printf 'P5\n640 480\n255\n' && tail -c +$((number * frame + 1)) "$work/640x480.grey" | head -c $frame; } |
            LD_LIBRARY_PATH=$jpeg/usr/lib/x86_64-linux-gnu "$jpeg/usr/bin/cjpeg" -quality 100 >"$into/$number.jpg"
        number=$((number + 1))
    done
    rm -rf "$work"
}
