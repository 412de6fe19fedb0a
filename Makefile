# `make demo` shows the whole chain; `make test` is what continuous integration runs.
# Needs: git, make, a C compiler, rustup (stable), Python >= 3.10.

PYTHON ?= python3
CARGO ?= cargo
TARGET := $(or $(CARGO_TARGET_DIR),target)
BSDF := $(abspath $(TARGET))/release/bsdf
VENV := .venv
DEMO := demo
MATERIAL ?= brushed-metal
# Cargo gives a crate the features that all packages of one build ask for: what is built together with the command is not
# compiled twice.
export PACKAGES ?= -p bsdfkit-cli

.PHONY: all build demo demo-catalog test lint rust interop c python parity viewer viewer-if-possible viewer-tests viewer-picture examples install-c bench bench-query bench-left-out bench-ablation traced fuzz asan soak tsan release clean

all: build

build:
	$(CARGO) build --release --locked $(PACKAGES)

# Measure a virtual specimen, fit it, tabulate it, check the files, draw an incidence that was not measured.
demo: build
	rm -rf $(DEMO) && mkdir -p $(DEMO)
	$(BSDF) simulate $(MATERIAL) -o $(DEMO)/measurements
	$(BSDF) fit $(DEMO)/measurements -o $(DEMO)/$(MATERIAL).safetensors \
		-o $(DEMO)/$(MATERIAL).xml --to klems-full -o $(DEMO)/$(MATERIAL)_klems.xml
	$(BSDF) check $(DEMO)/measurements $(DEMO)/$(MATERIAL).safetensors \
		$(DEMO)/$(MATERIAL).xml $(DEMO)/$(MATERIAL)_klems.xml
	$(BSDF) hemispherical $(DEMO)/$(MATERIAL).xml
	$(BSDF) plot bsdfkit=$(DEMO)/$(MATERIAL).safetensors tree=$(DEMO)/$(MATERIAL).xml klems=$(DEMO)/$(MATERIAL)_klems.xml \
		--incident 37.5,15 --measurements $(DEMO)/measurements --linear $(DEMO)/measurements \
		--material $(MATERIAL) --panel 240 -o $(DEMO)/$(MATERIAL).png
	@echo "look at $(DEMO)/$(MATERIAL).png; $(DEMO)/$(MATERIAL).xml loads in Radiance"

# Measure thirteen virtual materials with few points, fit them, publish them (docs/guide/catalog.md): minutes.
CATALOG := build/catalog
FEW := --sweeps 10 --points-per-sweep 50 --spiral-points 200
demo-catalog: build
	mkdir -p $(CATALOG)/materials
	@for record in examples/catalog/*.toml; do \
		name=$$(basename $$record .toml); made=$(CATALOG)/materials/$$name; \
		cp $$record $$made.toml; \
		[ -f $$made.safetensors ] && [ -f $$made.xml ] && continue; \
		rm -rf $(CATALOG)/measured/$$name && mkdir -p $(CATALOG)/measured && \
		$(BSDF) simulate $$name $(FEW) -o $(CATALOG)/measured/$$name && \
		$(BSDF) fit $(CATALOG)/measured/$$name -o $$made.safetensors -o $$made.xml --max-leaves 60000 || exit 1; \
	done
	$(BSDF) catalog build $(CATALOG)/materials -o $(CATALOG)/site --title "Virtual materials"
	@echo "open $(CATALOG)/site/index.html"

test: lint viewer-if-possible rust examples interop c python parity viewer-tests

lint:
	@$(CARGO) clippy --version >/dev/null 2>&1 && $(CARGO) fmt --version >/dev/null 2>&1 || rustup component add clippy rustfmt
	$(CARGO) fmt --all --check
	$(CARGO) fmt --manifest-path bindings/python/Cargo.toml --check
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings

# The test profile is optimised: statistics draw millions of samples.
rust:
	$(CARGO) test --locked --workspace

# Most of these tests wait for one program on one core.
SIDE_BY_SIDE ?= -n auto --dist loadfile

# Radiance's own programs, WINDOW's engine, EnergyPlus and Mitsuba read what we write.
interop: build $(VENV)/installed
	BSDF=$(BSDF) $(VENV)/bin/python -m pytest -q -rs $(SIDE_BY_SIDE) tests/interop

$(VENV)/installed: tests/interop/requirements.txt
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check -r $<
	touch $@

# The C library as strangers use it: installed, found by CMake and pkg-config, examples as C99 and C++17, under valgrind.
c:
	tests/install/run.sh

install-c: PACKAGES :=
install-c:
	$(MAKE) -C bindings/c install PREFIX=$(or $(PREFIX),/usr/local)

python: build $(VENV)/installed
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check '.[test]'
	BSDF=$(BSDF) $(VENV)/bin/python -m pytest -q $(SIDE_BY_SIDE) bindings/python/tests

# The viewer's page, which commands and wheels built after it hold. Needs node and Rust's target wasm32-unknown-unknown.
viewer:
	viewer/build.sh

viewer-if-possible:
	viewer/build.sh --if-possible

# A browser opens it, drags, hovers and reads the numbers.
viewer-tests: build
	BSDF=$(BSDF) tests/viewer/run.sh

# The picture of the documentation, of what `make demo` made.
viewer-picture:
	node tests/viewer/picture.mjs docs/figures/viewer.png $(BSDF) $(DEMO)/$(MATERIAL).xml $(DEMO)/measurements

# The same small program in every language prints the same text.
parity: build c python
	$(CARGO) build --release --locked $(PACKAGES) -p bsdfkit-examples
	@if [ -x build/c/cmake/parity ]; then c=build/c/cmake/parity; fi; \
	BSDF=$(BSDF) tests/parity/run.sh $(abspath $(TARGET))/release/parity $$c \
		"$(VENV)/bin/python examples/python/parity.py" "$(PYTHON) examples/command/parity.py $(BSDF)"

# From measurements to a file in Rust; fails unless the file says what was fitted.
EXAMPLES := build/examples
examples: build
	$(CARGO) build --release --locked $(PACKAGES) -p bsdfkit-examples
	rm -rf $(EXAMPLES) && mkdir -p $(EXAMPLES)
	$(BSDF) simulate fritted-glass --sweeps 12 --points-per-sweep 60 --spiral-points 300 -o $(EXAMPLES)/measured
	$(abspath $(TARGET))/release/fit $(EXAMPLES)/measured $(EXAMPLES)/glass.xml
	$(BSDF) check $(EXAMPLES)/glass.xml

# Every bench runs peers beside ours and prints both.
bench: build $(VENV)/installed
	BSDF=$(BSDF) $(VENV)/bin/python benches/run.py

# make bench-left-out FOLDER=measurements: each incidence predicted from the others.
bench-left-out: build $(VENV)/installed
	BSDF=$(BSDF) $(VENV)/bin/python benches/left_out.py $(FOLDER)

# make bench-ablation OPTIONS='--against main=OTHER/bsdf': every material that may be looked at (benches/held_back.md).
bench-ablation: build $(VENV)/installed
	BSDF=$(BSDF) $(VENV)/bin/python benches/ablation.py $(if $(wildcard build/traced),--traced build/traced) $(OPTIONS)

# Ray-traced specimens, for the bench above; needs LLVM 19 (benches/raytraced/README.md).
traced:
	$(PYTHON) -m venv build/raytraced
	build/raytraced/bin/python -m pip install --quiet --disable-pip-version-check -r benches/raytraced/requirements.txt .
	build/raytraced/bin/python -m pytest -q benches/raytraced
	build/raytraced/bin/python benches/raytraced/trace.py build/traced

# One query at a time: Radiance's library beside ours.
bench-query: $(VENV)/installed
	$(VENV)/bin/python benches/query.py build/query

# Threads that query one handle, under ThreadSanitizer, the standard library with them. Not part of `test`.
NIGHTLY ?= nightly
HOST = $(shell rustc -vV | sed -n 's/^host: //p')
tsan:
	@if ! rustc +$(NIGHTLY) --version >/dev/null 2>&1; then \
		echo "no toolchain $(NIGHTLY): rustup toolchain install $(NIGHTLY)"; exit 1; \
	elif [ ! -d "$$(rustc +$(NIGHTLY) --print sysroot)/lib/rustlib/src" ]; then \
		echo "no sources of the standard library: rustup component add rust-src --toolchain $(NIGHTLY)"; exit 1; fi
	RUSTFLAGS=-Zsanitizer=thread CARGO_TARGET_DIR=$(TARGET)/tsan $(CARGO) +$(NIGHTLY) test -Zbuild-std --target $(HOST) \
		-p bsdfkit --test threads

# Hostile bytes for every reader by libFuzzer, FUZZ_SECONDS a target: make fuzz FUZZ_SECONDS=1200 FUZZ_TARGETS="xml sir".
# A find lies in build/fuzz/TARGET and is run again by giving its path to the target's program (SECURITY.md).
FUZZ_SECONDS ?= 60
FUZZ_TARGETS ?= measurement tables xml xml_parts container container_parts sir record c_abi
# What cargo-fuzz gives, without a sanitizer: no toolchain but stable is needed.
FUZZ_FLAGS := -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
	-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
	-Cllvm-args=-sanitizer-coverage-trace-compares
fuzz:
	RUSTFLAGS="$(FUZZ_FLAGS)" $(CARGO) build --release --locked --target $(HOST) --manifest-path fuzz/libfuzzer/Cargo.toml
	fuzz/run.sh fuzz/libfuzzer/target/$(HOST)/release $(FUZZ_SECONDS) $(FUZZ_TARGETS)

# The C library and its programs under AddressSanitizer (tests/install/asan.sh says what that sees).
asan:
	tests/install/asan.sh

# Queries by four threads from C and requests to the viewer's server: memory does not grow (benches/soak).
QUERIES ?= 100000000
REQUESTS ?= 100000
soak: build
	BSDF=$(BSDF) benches/soak/run.sh $(QUERIES) $(REQUESTS)

# Wheels, source distribution, source crates and their checksums in build/release; publishes nothing.
release:
	release/build.sh

clean:
	$(CARGO) clean
	rm -rf $(VENV) $(DEMO)
