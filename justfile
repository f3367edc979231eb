# Everything is cargo; these are only shorter names.

# Generate all scenes for all targets.
build:
    cargo run -- build scenes-src

# All tests; renderers and reference images that are missing are skipped and named.
test:
    cargo test

# Formatting and lints.
check:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets -- -D warnings

# Rewrite snapshots and expected files.
bless:
    INSTA_UPDATE=always cargo test

# Benchmarks, on demand.
bench:
    cargo bench -p ltsc-core
