#!/usr/bin/env bash
# Runs a program in a small virtual machine on Debian's own kernel, where drivers are real and hardware is not: two
# cameras of the kernel's test driver vivid (/dev/video0 with an output beside it, and a multi-planar one), a parallel
# port whose interrupt line is an input for pulses per second (/dev/pps0), a second serial port (/dev/ttyS1), a GPIO chip
# (the driver of an I/O card on a SCSI card, whose memory takes the place of the registers and may be looked at:
# iomem=relaxed), a USB serial adapter (/dev/ttyUSB0) whose other end is /dev/ttyS2 and which is pulled and plugged by
# orders to QEMU through /dev/ttyS3, a loopback network, systemd as process 1. The program is the one
# built here with this machine's libraries: /usr and the source tree are mounted read-only at the same places. Nothing
# is installed and no module is loaded outside.
#
#   machine.sh [--time S] PROGRAM [ARGUMENT...]
#
# Exit status: the program's; 124: time limit; 125: the machine ended without a result (its console's end is shown);
# 126: this computer cannot run it, and why.
# KAWARA_VM_CACHE: where the kernel is kept (30 MB). KAWARA_VM_ACCEL: QEMU's accelerator; the default, tcg, works
# everywhere and is 30 to 80 times slower than the computer itself.
set -euo pipefail
export PATH=$PATH:/usr/sbin:/sbin
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
tree=$(cd "$here/../.." && pwd)
cache=${KAWARA_VM_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/kawaraban/vm}
limit=600
[ "${1:-}" = --time ] && { limit=$2; shift 2; }
[ $# -gt 0 ] || { sed -n '2,/^set/p' "$0" | sed '$d; s/^# \{0,1\}//' >&2; exit 126; }
impossible() {
  echo "machine.sh: $*" >&2
  exit 126
}
for pair in python3:python3 qemu-system-x86_64:qemu-system-x86 busybox:busybox-static depmod:kmod cpio:cpio; do
  command -v "${pair%%:*}" >/dev/null || impossible "${pair%%:*} is missing (Debian package ${pair#*:})"
done

[ -x /usr/lib/systemd/systemd ] || impossible "systemd is missing (Debian package systemd)"

# The kernel: of Debian's newest package the image and what this machine needs of its modules.
modules='9p 9pnet_virtio virtio_pci vivid parport_pc pps_parport gpio-pci-idio-16 xhci_pci ftdi_sio'
vivid_options='n_devs=2 node_types=0x101,0x1 multiplanar=1,2'
parport_options='io=0x378 irq=7'
make_kernel() { # folder
  local work=$1 package version file module
  package=$(apt-cache depends linux-image-amd64 2>/dev/null | grep -oE 'linux-image-[0-9][^ ]*' | head -1) || true
  [ -n "$package" ] || impossible "apt knows no linux-image-amd64 (apt-get update; Debian 12 on amd64 is expected)"
  (cd "$work" && apt-get -qq -o APT::Sandbox::User=root download "$package" >&2) ||
    impossible "$package cannot be downloaded (no network?)"
  dpkg-deb --fsys-tarfile "$work"/*.deb | tar -x -C "$work" --wildcards './boot/vmlinuz-*' './lib/modules/*/modules.*' \
    '*/kernel/drivers/media/*' '*/kernel/drivers/virtio/*' '*/kernel/fs/9p/*' '*/kernel/fs/netfs/*' \
    '*/kernel/fs/fscache/*' '*/kernel/net/9p/*' '*/kernel/drivers/video/*' '*/kernel/drivers/parport/*' '*/kernel/drivers/pps/*' '*/kernel/drivers/gpio/*' '*/kernel/drivers/usb/*'
  version=$(ls "$work/lib/modules")
  depmod -b "$work" "$version" 2>/dev/null
  mkdir -p "$work"/initrd/{bin,modules,proc,sys,dev}
  cp "$(command -v busybox)" "$work/initrd/bin/busybox"
  ! ldd "$work/initrd/bin/busybox" >/dev/null 2>&1 || impossible "busybox is not static (Debian package busybox-static)"
  for module in $modules; do
    modprobe -d "$work" -S "$version" --show-depends "$module" | sed -n 's/^insmod //p' ||
      impossible "$package has no module $module"
  done | awk '!seen[$1]++ {print $1}' >"$work/files"
  while read -r file; do
    cp "$file" "$work/initrd/modules/"
    case ${file##*/} in
      vivid.ko*) echo "${file##*/} $vivid_options" ;;
      parport_pc.ko*) echo "${file##*/} $parport_options" ;;
      *) echo "${file##*/}" ;;
    esac
  done <"$work/files" >"$work/initrd/modules/list"
  cp "$here/init" "$work/initrd/init"
  chmod 755 "$work/initrd/init"
  (cd "$work/initrd" && find . | LC_ALL=C sort | cpio -o -H newc --quiet --reproducible | gzip -n1) >"$work/initrd.gz"
  mv "$work/boot/vmlinuz-$version" "$work/vmlinuz"
  # Taken out of its wrapping here, the kernel starts in half the time there.
  local at
  at=$(LC_ALL=C grep -abom1 $'\xfd7zXZ' "$work/vmlinuz" | head -1 | cut -d: -f1 || true)
  if [ -n "$at" ] && tail -c +$((at + 1)) "$work/vmlinuz" | xz -dcq >"$work/plain" 2>/dev/null || [ -s "$work/plain" ]; then
    [ "$(head -c 4 "$work/plain" | tail -c 3)" != ELF ] || mv "$work/plain" "$work/vmlinuz"
  fi
  rm -rf "$work"/{*.deb,boot,lib,initrd,files,plain}
}

mkdir -p "$cache" || impossible "$cache cannot be made"
# A new one whenever what goes into it changes.
kernel=$cache/$(cat "$here/init" "$here/machine.sh" | sha256sum | cut -c1-16)
exec 9>"$cache/lock"
flock 9
if [ ! -s "$kernel/initrd.gz" ]; then
  rm -rf "$cache"/[0-9a-f]*
  mkdir "$kernel.new"
  make_kernel "$kernel.new"
  mv "$kernel.new" "$kernel"
fi
flock -u 9
exec 9>&-

job=$(mktemp -d "${TMPDIR:-/tmp}/kawara-vm.XXXXXX")
cable=
# The cable ends by itself with the machine: then there is nothing to kill, and that is no failure.
trap '[ -z "$cable" ] || kill "$cable" 2>/dev/null || true; rm -rf "$job"' EXIT
mkdir "$job/etc"
cp -a /etc/ld.so.cache /etc/alternatives "$job/etc/"
echo "s0 $tree" >"$job/shares"
{
  printf 'cd %q && exec' "$PWD"
  printf ' %q' "$@"
  echo
} >"$job/command"

share() { # tag folder options
  arguments+=(-fsdev "local,id=$1,path=$2,security_model=none,multidevs=remap$3"
    -device "virtio-9p-pci,fsdev=$1,mount_tag=$1")
}
arguments=(-nodefaults -no-user-config -display none -no-reboot -nic none -M q35 -cpu max -smp 2 -m 1024
  -accel "${KAWARA_VM_ACCEL:-tcg,thread=multi}" -kernel "$kernel/vmlinuz" -initrd "$kernel/initrd.gz"
  -chardev null,id=lpt -device isa-parallel,chardev=lpt -chardev null,id=com2 -serial chardev:com2
  -device lsi53c895a -device qemu-xhci
  -chardev "socket,id=adapter,path=$job/adapter" -device usb-serial,id=adapter,chardev=adapter
  -chardev "socket,id=orders,path=$job/orders,server=on,wait=off" -mon chardev=orders,mode=readline
  -chardev "socket,id=far,path=$job/far" -chardev "socket,id=hand,path=$job/orders"
  -device pci-serial-2x,chardev1=far,chardev2=hand
  -append 'console=ttyS0 quiet panic=-1 iomem=relaxed' -chardev "file,id=console,path=$job/console" -serial chardev:console)
share usr /usr ,readonly=on
share job "$job" ''
share s0 "$tree" ,readonly=on
/usr/bin/python3 -B "$here/null_modem.py" "$job/adapter" "$job/far" >"$job/cable" &
cable=$!
for _ in $(seq 100); do
  [ ! -s "$job/cable" ] || break
  sleep 0.1
done
status=0
timeout -k 5 "$limit" qemu-system-x86_64 "${arguments[@]}" </dev/null || status=$?
[ ! -f "$job/output" ] || cat "$job/output"
[ ! -s "$job/status" ] || exit "$(cat "$job/status")"
[ "$status" != 124 ] || { echo "machine.sh: time limit of $limit s" >&2; exit 124; }
echo "machine.sh: the machine ended without a result (QEMU: $status); the end of its console:" >&2
tail -n 20 "$job/console" >&2 || true
exit 125
