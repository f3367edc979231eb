# Everything is cargo; these are only shorter names.

# Generate all scenes for all targets.
build:
    cargo run -- build scenes-src

# The tests of minutes; renderers and reference images that are missing are skipped and named.
test:
    cargo test

# The long tests: more scenes, more samples.
long:
    cargo test -- --ignored

# Formatting and lints.
check:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets -- -D warnings

# Rewrite snapshots and expected files.
bless:
    INSTA_UPDATE=always cargo test
    INSTA_UPDATE=always cargo test --test suite -- --ignored mutations:: pages::

# Benchmarks, on demand.
bench:
    cargo bench -p ltsc-core

# Fuzz one target (parse, evaluate, mesh_file, image_file, ...) from the scenes and cases; needs cargo-fuzz and a nightly compiler.
fuzz target seconds="600":
    mkdir -p fuzz/corpus/{{target}}
    find scenes-src tests/cases -type f -size -64k -not -name '*.snap' | while read -r f; do cp "$f" "fuzz/corpus/{{target}}/$(echo "$f" | tr / _)"; done
    cargo +nightly fuzz run {{target}} -- -max_total_time={{seconds}} -rss_limit_mb=1024 -timeout=10 -max_len=65536
