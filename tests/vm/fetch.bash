# Sourced by run: kernel, emulator and guest tools of one architecture, as Debian packages unpacked under target/vm.
#
# Neither root nor an installation is needed, and the host's package state is never touched: apt gets folders of its own.
# What was fetched once is used from then on without a network.

# The package names, and which of the host's own programs run the emulator.
case $arch in
x86_64) debian=amd64 emulator_package=qemu-system-x86 ;;
aarch64) debian=arm64 emulator_package=qemu-system-arm ;;
*) say "unknown architecture '$arch': x86_64 or aarch64" && exit 2 ;;
esac

emulator=$cache/emulator-$arch
kernel=$cache/kernel-$arch
tools=$cache/tools-$arch

# An apt that knows both architectures and of no installed package, so that it names all that is needed.
make_private_apt() {
    [ ! -e "$cache/apt/complete" ] || return 0
    rm -rf "$cache/apt" && mkdir -p "$cache"/apt/{lists/partial,cache/archives/partial}
    : >"$cache/apt/status"
    cat >"$cache/apt/apt.conf" <<CONF
Dir::State "$cache/apt";
Dir::State::status "$cache/apt/status";
Dir::Cache "$cache/apt/cache";
Dir::Log "$cache/apt";
APT::Architecture "amd64";
APT::Architectures { "amd64"; "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Acquire::Languages "none";
Acquire::Retries "1";
Acquire::http::Timeout "30";
CONF
    private_apt apt-get -qq update && touch "$cache/apt/complete"
}

private_apt() { APT_CONFIG=$cache/apt/apt.conf timeout 600 "$@" </dev/null >&2; }

# fetch FOLDER PACKAGE...: the packages and all that they need, unpacked into the folder.
fetch() {
    local folder=$1 package
    shift
    [ "$(cat "$folder/complete" 2>/dev/null)" != "$*" ] || return 0
    say "fetching $* into $folder (once)"
    make_private_apt || return 1
    rm -rf "$folder" "$folder.packages" && mkdir -p "$folder" "$folder.packages/partial"
    private_apt apt-get -qq -o Dir::Cache::archives="$folder.packages" install --yes --download-only "$@" || return 1
    for package in "$folder.packages"/*.deb; do
        dpkg -x "$package" "$folder" || return 1
    done
    rm -rf "$folder.packages" && echo "$*" >"$folder/complete"
}

# Only what is needed of the kernel's 400 MB: itself, and the drivers of video devices.
fetch_kernel() {
    [ ! -e "$kernel/complete" ] || return 0
    make_private_apt || return 1
    local package
    package=$(APT_CONFIG=$cache/apt/apt.conf apt-cache depends "linux-image-$debian:$debian" |
        sed -n 's/.*Depends: \(linux-image.*\)/\1/p' | head -n 1)
    [ -n "$package" ] || return 1
    say "fetching $package into $kernel (once)"
    rm -rf "$kernel" && mkdir -p "$kernel"
    (cd "$kernel" && private_apt apt-get -qq download "$package") || return 1
    dpkg --fsys-tarfile "$kernel"/*.deb |
        tar -x -C "$kernel" --wildcards './boot/vmlinuz*' '*/modules.builtin' '*/drivers/media/*' || return 1
    rm -f "$kernel"/*.deb && touch "$kernel/complete"
}

fetch_all() {
    command -v apt-get >/dev/null || [ -e "$kernel/complete" ] || skip "there is no apt-get"
    fetch_kernel || skip "apt could not provide the kernel"
    fetch "$emulator" "$emulator_package" || skip "apt could not provide $emulator_package"
    fetch "$tools" "busybox-static:$debian" "v4l-utils:$debian" || skip "apt could not provide busybox-static and v4l-utils"
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
