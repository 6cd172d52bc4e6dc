# Sourced by run: kernel, emulator and guest tools of one architecture, as Debian packages unpacked under target/vm.

# The package names, and which of the host's own programs run the emulator.
case $arch in
x86_64) debian=amd64 emulator_package=qemu-system-x86 ;;
aarch64) debian=arm64 emulator_package=qemu-system-arm ;;
*) say "unknown architecture '$arch': x86_64 or aarch64" && exit 2 ;;
esac

emulator=$cache/emulator-$arch
kernel=$cache/kernel-$arch
tools=$cache/tools-$arch
# Of this machine's kind.
host_tools=$cache/tools-x86_64

# Only what is needed of the kernel's 400 MB: itself, and the drivers of video devices.
fetch_kernel() {
    [ ! -e "$kernel/complete" ] || return 0
    with_fresh_lists download_kernel || return 1
    dpkg --fsys-tarfile "$kernel"/*.deb |
        tar -x -C "$kernel" --wildcards './boot/vmlinuz*' '*/modules.builtin' '*/drivers/media/*' || return 1
    rm -f "$kernel"/*.deb && touch "$kernel/complete"
}

download_kernel() {
    local package
    package=$(with_private_apt apt-cache depends "linux-image-$debian:$debian" |
        sed -n 's/.*Depends: \(linux-image.*\)/\1/p' | head -n 1)
    [ -n "$package" ] || return 1
    say "fetching $package into $kernel (once)"
    rm -rf "$kernel" && mkdir -p "$kernel"
    (cd "$kernel" && with_private_apt apt-get -qq download "$package" >&2)
}

fetch_all() {
    [ "$(uname -m)" = x86_64 ] || skip "the emulators are only prepared for x86-64 machines, and this is $(uname -m)"
    command -v apt-get >/dev/null || [ -e "$kernel/complete" ] || skip "there is no apt-get"
    fetch_kernel || skip "apt could not provide the kernel"
    fetch_packages "$emulator" "$emulator_package" || skip "apt could not provide $emulator_package"
    fetch_packages "$tools" "busybox-static:$debian" "v4l-utils:$debian" ||
        skip "apt could not provide busybox-static and v4l-utils"
    [ -e "$host_tools/bin/busybox" ] || fetch_packages "$host_tools" busybox-static:amd64 v4l-utils:amd64 ||
        skip "apt could not provide busybox-static"
}

# A module and before it all that it depends on, as file names in the order of loading.
modules_of() {
    local wanted=${1//-/_} file depends each
    case " ${seen_modules:=} " in *" $wanted "*) return 0 ;; esac
    seen_modules+=" $wanted"
    # In names of files - and _ are the same. What is not among the drivers is built into the kernel.
    file=$(find "$kernel" -name "${wanted//_/[-_]}.ko*")
    [ -n "$file" ] || return 0
    depends=$(plain_module "$file" | grep -aom 1 'depends=[[:alnum:]_,-]*' | cut -d = -f 2 | tr , ' ')
    for each in $depends; do modules_of "$each"; done
    echo "$file"
}

plain_module() {
    case $1 in
    *.xz) xz -dc "$1" ;;
    *) cat "$1" ;;
    esac
}
