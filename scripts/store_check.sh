#!/bin/sh
# What a store promises, at length: a hundred SIGKILLs of a process that writes passes, a full disk (a tmpfs of 2 MiB, where this user may
# mount one), stations in per second and a day out of ten million (a gigabyte below TMPDIR, a minute or two).
#   sh scripts/store_check.sh
set -eu
test() {
  ${CARGO:-cargo} test --release --locked --lib -- --ignored --exact --nocapture "$1" | grep -v '^$'
}
test inside::store::killed::a_hundred_kills_lose_nothing
small=$(mktemp -d)
trap 'umount "$small" 2>/dev/null || true; rmdir "$small"' EXIT
if mount -t tmpfs -o size=2m none "$small" 2>/dev/null; then
  SHADOWGAUGE_SMALL_DISK=$small test inside::store::full_disk::a_full_disk_is_named_and_nothing_is_lost
else
  echo "SKIPPED: a full disk is not tried: this user may not mount a tmpfs (a limit of the files' length is tried by the tests)" >&2
fi
test inside::store::speed::twenty_thousand_stations_a_second_in_and_a_day_of_ten_million_out
