#!/bin/sh
# Fuzzes every target for some time (seconds each, default 300) with a stable compiler: coverage counters go into this crate and the
# targets by a wrapper around rustc, without a sanitizer. cargo-fuzz on nightly does the same with one. Exit 1 where a target fails.
set -eu
cd "$(dirname "$0")"
seconds=${1:-300}
target=${CARGO_TARGET_DIR:-$PWD/target}
mkdir -p "$target"
wrapper="$target/rustc-with-counters.sh"
cat > "$wrapper" <<'WRAPPER'
#!/bin/sh
rustc=$1; shift
case " $* " in
*" --crate-name shadowgauge "* | *" --crate-name decode "* | *" --crate-name calibration "* | *" --crate-name measure "* | \
*" --crate-name gvcp "* | *" --crate-name model "* | *" --crate-name receiver "* | *" --crate-name viva_gige "*)
  exec "$rustc" "$@" -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares ;;
*) exec "$rustc" "$@" ;;
esac
WRAPPER
chmod +x "$wrapper"
[ -f Cargo.lock ] || cp ../Cargo.lock Cargo.lock
RUSTC_WRAPPER=$wrapper CARGO_TARGET_DIR=$target cargo build --release
failed=0
for name in decode calibration measure gvcp model receiver; do
  mkdir -p "corpus/$name" "artifacts/$name"
  [ -n "$(ls -A "corpus/$name")" ] || cp -r "seeds/$name/." "corpus/$name/"
  echo "== $name"
  "$target/release/$name" "corpus/$name" -max_total_time="$seconds" -max_len=30000 -timeout=20 -rss_limit_mb=3000 \
    -artifact_prefix="artifacts/$name/" -print_final_stats=1 2> "artifacts/$name.log" || failed=1
  grep -e 'DONE' -e 'ERROR' -e panicked -e 'number_of_executed_units' "artifacts/$name.log" || true
done
exit "$failed"
