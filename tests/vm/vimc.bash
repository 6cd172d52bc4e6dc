# Sourced by run: vimc, the kernel's test driver for cameras whose parts are set one by one (sensor, scaler, node), as those of
# embedded machines are. Debian's kernels do not have it, so it is built from their source, against their headers.

# Says why there is none, and goes on without it.
without_vimc() {
    say "the group pipeline is NOT run: no vimc, because $1"
    return 1
}

make_vimc() {
    [ ! -e "$kernel/vimc.ko" ] || return 0
    [ "$arch" = "$(uname -m)" ] || { without_vimc "tools of the kernel's build run on $arch only"; return 1; }
    command -v make >/dev/null && command -v gcc >/dev/null || { without_vimc "make or gcc is missing"; return 1; }
    local work=$cache/vimc-$arch version series
    version=$(basename "$kernel"/boot/vmlinuz-*) version=${version#vmlinuz-}
    series=$(cut -d . -f 1-2 <<<"$version")
    say "building vimc for $version (once)"
    rm -rf "$work" && mkdir -p "$work/packages"
    with_fresh_lists download_kernel_source || { without_vimc "apt could not provide the source of $version"; return 1; }
    unpack_kernel_source && compile_vimc >"$work/log" 2>&1 || { without_vimc "it could not be built ($work/log)"; return 1; }
    mv "$work/vimc/vimc.ko" "$kernel/vimc.ko" && rm -rf "$work"
}

download_kernel_source() {
    (cd "$work/packages" && with_private_apt apt-get -qq download "linux-headers-$version" \
        "linux-headers-${version%-"$debian"}-common" "linux-kbuild-$series" "linux-source-$series" >&2)
}

# Of the source only the driver: the whole has 1.3 GB.
unpack_kernel_source() {
    local package
    for package in "$work"/packages/linux-[hk]*.deb; do dpkg -x "$package" "$work" || return 1; done
    mkdir -p "$work/vimc"
    dpkg --fsys-tarfile "$work"/packages/linux-source*.deb | tar -xO "./usr/src/linux-source-$series.tar.xz" | xz -dc |
        tar -x -C "$work/vimc" --strip-components 5 --wildcards '*/drivers/media/test-drivers/vimc/*'
}

# The headers name each other by the place where they would be installed.
compile_vimc() {
    local headers=$work/usr/src/linux-headers-$version
    sed -i "s#/usr/src/#$work/usr/src/#" "$headers/Makefile"
    make -C "$headers" M="$work/vimc" CONFIG_VIDEO_VIMC=m CC="$(command -v gcc-12 || command -v gcc)" modules
}
