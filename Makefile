# Entry points of hati; `make` alone lists them. Everything runs without a terminal, and what is
# already done is not done again. GNU make, bash, no root.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
MAKEFLAGS += --no-print-directory

# Where rustup puts cargo when the shell's start-up file has not been read.
export PATH := $(PATH):$(HOME)/.cargo/bin

SCENE ?= scenes/site-response
OUT ?= runs/$(notdir $(patsubst %/,%,$(SCENE)))
FIGURE := $(OUT)/figures/profile-x.svg

# The choice of the NetCDF library: CARGO_ENV, FEATURES, NETCDF_IS. Made by the set-up, which make runs
# before it reads the file; only the goals that build need it.
WITHOUT_SETUP := help clean fmt licences
ifneq ($(filter-out $(WITHOUT_SETUP),$(MAKECMDGOALS)),)
include .cache/netcdf.mk
endif
.cache/netcdf.mk: force
	@scripts/setup >&2

CARGO := $(CARGO_ENV) cargo
HATI := $(CARGO) run --quiet $(FEATURES) --

.PHONY: force help setup build demo test test-long lint licences fmt bench docs figure env clean

help: ## List the targets.
	@sed -n 's/^\([a-z-]*\):[^#]*## \(.*\)/make \1	\2/p' Makefile | expand -t 18

setup: ## Make .venv, install the Python packages, choose the NetCDF library.
	@echo "set-up: ready; $$(.venv/bin/python --version), NetCDF: $(NETCDF_IS)" >&2

build: setup ## Build the program.
	@echo "build: cargo build $(FEATURES)"
	@$(CARGO) build $(FEATURES)

demo: build ## Run scenes/site-response and say where its report is (SCENE=..., OUT=...).
	@echo "demo: hati run $(SCENE) --out $(OUT)"
	@$(HATI) run $(SCENE) --out $(OUT) </dev/null
	@echo "demo: the report is $(CURDIR)/$(OUT)/report.html"

test: build ## Run all tests but the long ones.
	@echo 'test: examples in the documentation, and the book'
	@$(CARGO) test --workspace --doc --quiet $(FEATURES) </dev/null
	@$(CARGO_ENV) scripts/check-docs $(FEATURES)
	@echo 'test: everything else'
	@if $(CARGO) nextest --version >/dev/null 2>&1; then \
	  $(CARGO) nextest run --workspace --no-tests pass $(FEATURES) </dev/null; \
	else \
	  $(CARGO) test --workspace --lib --bins --tests $(FEATURES) </dev/null; \
	fi

test-long: build ## Run the tests marked as long, then every verification case.
	@if $(CARGO) nextest --version >/dev/null 2>&1; then \
	  $(CARGO) nextest run --workspace --run-ignored only --no-tests pass $(FEATURES) </dev/null; \
	else \
	  $(CARGO) test --workspace --lib --bins --tests $(FEATURES) -- --ignored </dev/null; \
	fi
	@$(HATI) verify --long </dev/null

lint: setup ## Check the format, and clippy without a warning.
	@echo 'lint: cargo fmt --all --check'
	@cargo fmt --all --check
	@echo 'lint: cargo clippy --workspace --all-targets'
	@$(CARGO) clippy --workspace --all-targets $(FEATURES) -- -D warnings

licences: ## Check the licences of the dependencies (cargo-deny).
	@cargo deny --version >/dev/null 2>&1 || { echo 'licences: cargo-deny is not installed (cargo install cargo-deny)' >&2; exit 1; }
	@cargo deny check licenses bans sources

fmt: ## Format all Rust sources.
	@cargo fmt --all

bench: setup ## Run the benchmarks; print the build time.
	@$(CARGO_ENV) scripts/bench $(FEATURES)

docs: build ## Write the scene reference and build the book (mdBook).
	@$(HATI) schema --markdown >.cache/scene-reference.md </dev/null
	@cmp -s .cache/scene-reference.md docs/src/scene-reference.md || \
	  { cp .cache/scene-reference.md docs/src/scene-reference.md; echo 'docs: docs/src/scene-reference.md is new'; }
	@if command -v mdbook >/dev/null 2>&1; then \
	  mdbook build docs && echo "docs: the book is $(CURDIR)/docs/book/index.html"; \
	else \
	  echo 'docs: mdBook is not installed (cargo install mdbook); the chapters read well as they are in docs/src'; \
	fi

figure: demo ## Draw the figures of README and book anew.
	@mkdir -p docs/src/figures
	@cp $(FIGURE) docs/src/figures/site-response.svg
	@$(HATI) chart scenes/three-layer --out runs/chart-three-layer </dev/null
	@cp runs/chart-three-layer/chart.svg docs/src/figures/chart-three-layer.svg
	@echo 'figure: docs/src/figures/site-response.svg, docs/src/figures/chart-three-layer.svg'

env: setup ## Print what to set to call cargo directly: eval "$(make -s env)"; cargo build $HATI_FEATURES
	@echo 'export HATI_FEATURES="$(FEATURES)" $(CARGO_ENV)'

clean: ## Remove what was built (not runs/; remove .venv and .cache to set up anew).
	@cargo clean
	@rm -rf docs/book
