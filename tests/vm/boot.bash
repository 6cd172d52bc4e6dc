# Sourced by run: the guest's files, and the emulator.

make_initramfs() {
    guest=$(mktemp -d "$cache/guest.XXXXXX")
    trap 'rm -rf "$guest"' EXIT
    # It becomes the root folder, which everybody in the guest may enter.
    chmod 755 "$guest"
    mkdir -p "$guest"/{bin,lib,lib64,modules,test,usr}
    cp "$tools/bin/busybox" "$guest/bin/"
    cp "$tools"/usr/bin/{v4l2-ctl,media-ctl} "$guest/bin/"
    # Their libraries, at one place; links as what they point to.
    find "$tools" \( -name 'lib*.so.[0-9]*' -o -name 'ld-linux*' \) -not -name '*.py' -exec cp -L {} "$guest/lib/" \;
    cp -L "$guest"/lib/ld-linux* "$guest/lib64/"
    local number=10 module
    for module in $(modules_of vivid); do
        plain_module "$module" >"$guest/modules/$number-$(basename "${module%.xz}")"
        number=$((number + 1))
    done
    # Loaded by its group only.
    [ ! -e "$kernel/vimc.ko" ] || cp "$kernel/vimc.ko" "$guest/test/"
    local program
    for program in tagbus tagbus-vm; do
        "${strip_program[@]}" -o "$guest/bin/$program" "$programs/$program"
    done
    paint "$guest/test/pictures"
    # What a test brings beside these.
    [ -z "${extra_files:-}" ] || cp -a "$extra_files/." "$guest/"
    cp tests/vm/init "$guest/init"
    cp tests/vm/guest "$guest/test/guest"
    echo "$cases" >"$guest/test/cases"
    (cd "$guest" && find . | "$host_tools/bin/busybox" cpio -o -H newc 2>/dev/null) >"$cache/initramfs-$arch"
    say "initramfs of $(du -m "$cache/initramfs-$arch" | cut -f 1) MB"
}

# Nothing waits for ever: the guest ends itself after this time, and the emulator is ended a minute later.
guest_seconds=${TAGBUS_VM_SECONDS:-300}

# boot GROUP: one cycle from the emulator's start to the verdict.
boot() {
    local log=$cache/console-$arch-$1.log started=$EPOCHREALTIME verdict=passed took
    say "booting for $1"
    emulate "$1" </dev/null 2>&1 | tee "$log" || true
    # The kernel's own word that a processor of the emulator turns in circles: of cameras that says nothing.
    if ! tr -d '\r' <"$log" | grep -q '^TEST-RC' && grep -q 'soft lockup' "$log"; then
        say "$arch $1: THE EMULATED KERNEL LOCKED UP and said no verdict: booting once more"
        started=$EPOCHREALTIME
        emulate "$1" </dev/null 2>&1 | tee "$log" || true
    fi
    took=$(awk "BEGIN { printf \"%.1f\", $EPOCHREALTIME - $started }")
    tr -d '\r' <"$log" | grep -q '^TEST-RC 0$' || verdict=FAILED
    cases_passed=$(tr -d '\r' <"$log" | sed -n 's/.* \([0-9]*\) cases passed.*/\1/p')
    # Its two processors are busy all the time; what goes beyond that is other work of the host.
    say "$arch $1: $verdict, ${cases_passed:-0} cases, $took s from boot to verdict, load $(cut -d ' ' -f 1 /proc/loadavg)"
    [ $verdict = passed ] || {
        say "the guest ended with '$(tr -d '\r' <"$log" | grep '^TEST-RC' || echo no word)'"
        return 1
    }
}

# The processor is emulated as well (tcg): that works in any container, and a nested machine's help (kvm) does not. Simple
# processors: what newer ones add takes an emulator longer than it saves.
emulate() {
    local machine console
    case $arch in
    x86_64) machine=(-M pc -cpu qemu64) console=ttyS0 ;;
    aarch64) machine=(-M virt -cpu cortex-a72) console=ttyAMA0 ;;
    esac
    QEMU_MODULE_DIR=$emulator/usr/lib/x86_64-linux-gnu/qemu timeout $((guest_seconds + 60)) \
        "$emulator/lib64/ld-linux-x86-64.so.2" \
        --library-path "$emulator/lib/x86_64-linux-gnu:$emulator/usr/lib/x86_64-linux-gnu" \
        "$emulator/usr/bin/qemu-system-$arch" -L "$emulator/usr/share/qemu" -L "$emulator/usr/share/seabios" \
        "${machine[@]}" -accel tcg,thread=multi -smp 2 -m 1536 -display none -nodefaults -no-reboot -serial stdio \
        -kernel "$(echo "$kernel"/boot/vmlinuz-*)" -initrd "$cache/initramfs-$arch" \
        -append "console=$console panic=-1 loglevel=3 group=$1 seconds=$guest_seconds"
}
