# tagbus: `make run` shows live detections of the built-in scene, `make test` runs every test. Both set up what is
# missing. `make` alone says what else there is.

# Where frames come from; see `tagbus camera --help`. A folder: make run SOURCE=replay:FOLDER
SOURCE ?= scene
# Further flags for `tagbus run`: make run ARGS="--family tag36h11,tagStandard41h12 --decimate 1"
ARGS ?=

TARGET := $(or $(CARGO_TARGET_DIR),target)
# rustup's folder is not on every PATH, for one not on that of a CI job.
export PATH := $(PATH):$(HOME)/.cargo/bin

# Before each build: where libclang is, and whether the crate v4l can be built (tools/libclang). Sets $features.
SET_UP = tools/toolchain && tools/libclang '$(TARGET)/build.env' && . '$(TARGET)/build.env'
# One profile for everything, so that nothing is built twice.
ALL = --release --workspace $$features

.DEFAULT_GOAL := help
.PHONY: help run test vm dist build lint format-check clippy doc

help: ## say what there is to make
	@sed -n 's/^\([a-z-]*\):.*## /\1|/p' $(MAKEFILE_LIST) | while IFS='|' read -r name text; do \
		printf '  make %-13s %s\n' "$$name" "$$text"; done
	@echo
	@echo '  make run SOURCE=replay:FOLDER    pictures of a folder instead of the built-in scene'
	@echo '  make run ARGS="--decimate 1"     further flags of tagbus run'
	@echo '  TAGBUS_LIBCLANG=none make ...    without video devices, when libclang cannot be had (tools/libclang)'

# The shell is replaced by tagbus (exec), so Ctrl-C and kill reach it; should make itself be killed with -9, the kernel
# tells tagbus (setpriv is in every Debian, and left out elsewhere). Built with the features of the whole workspace, so that
# `make run` and `make test` share what they build.
WITH_MAKE = $(shell setpriv --pdeathsig TERM echo setpriv --pdeathsig TERM 2>/dev/null)

run: ## set up what is missing and run camera, detector and watch on SOURCE (scene)
	@$(SET_UP) && cargo build $(ALL) --bin tagbus && exec $(WITH_MAKE) '$(TARGET)/release/tagbus' run --source '$(SOURCE)' $(ARGS)

test: ## set up what is missing and run every test (real pictures: TAGBUS_TEST_DATA=FOLDER)
	@[ -n "$$TAGBUS_TEST_DATA" ] || echo 'make test: TAGBUS_TEST_DATA is not set, tests on real pictures are SKIPPED' >&2
	@$(SET_UP) && exec cargo test $(ALL)

vm: ## test cameras with drivers of a real kernel in a virtual machine (x86-64 Debian; ARCH=aarch64, CASES=a group or a pattern)
	@exec tests/vm/run '$(ARCH)' '$(CASES)'

dist: ## build what goes onto a robot, which wakes sooner and takes minutes to build: target/dist/tagbus
	@$(SET_UP) && exec cargo build --profile dist -p tagbus-cli $$features

build: ## build everything; the program is then target/release/tagbus
	@$(SET_UP) && exec cargo build $(ALL)

lint: format-check clippy doc ## everything that CI wants beside the tests

format-check: ## say where `cargo fmt` would change something
	@cargo fmt --check

clippy: ## lints, warnings denied; and whether the fuzz targets, a workspace of their own, can still be built as they were
	@cargo metadata --locked --format-version 1 --manifest-path message/fuzz/Cargo.toml >/dev/null
	@$(SET_UP) && exec cargo clippy $(ALL) --all-targets -- -D warnings

doc: ## the documentation of all rooms, warnings denied
	@$(SET_UP) && RUSTDOCFLAGS='-D warnings' exec cargo doc $(ALL) --no-deps
