# make test     install what is missing, build, run all tests
# make demo     build, simulate, map, evaluate: rali-demo/out/report.html and rali-demo/map.png
# make install PREFIX=/usr/local   program, manual page, completions, documents, library, Python module
# make deb      build/packages/*.deb: rali, librali-dev, python3-rali; make check-deb installs, uses and
#               removes them in a chroot
# make bundle   the scripts of report.html again, into web/dist, after a change in web/ (needs npm)
# make fuzz     each fuzz target for FUZZ_SECONDS (needs clang)
# make bench    Google Benchmark programs
# make soak     vehicles over an emulated bad radio, for longer (needs root)
# make regression   figures that must not get worse, against bench/regression/baseline_short.csv
# make docs     generated pages; make tutorials: what they print; make site: build/site/index.html
# make asan | tsan | lint | format | clean
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := test
.PHONY: test demo install deb bundle check-deb share fuzz soak bench regression format lint asan tsan docs tutorials figures site packages release clean

JOBS ?= $(shell nproc)
FUZZ_SECONDS ?= 60
DEV_PACKAGES := clang clang-format clang-tidy
CTEST := ctest --output-on-failure --no-tests=error -j $(JOBS)
SOURCES = git ls-files 'src/*.hpp' 'src/*.cpp' 'include/*.hpp' 'python/*.hpp' 'python/*.cpp' 'examples/*.cpp' \
  'tests/*.cpp' 'bench/*.cpp' 'bench/*.hpp'

# Installs the packages of Debian 12 that are missing, if we may.
packages:
	@tools/install_packages.sh $$(cat packages.txt)

release: packages
	cmake --preset release -DRALI_BENCH=OFF
	cmake --build build/release -j $(JOBS)

test: release
	$(CTEST) --test-dir build/release

demo: packages
	cmake --preset release -DRALI_BENCH=OFF
	cmake --build build/release -j $(JOBS) --target rali
	RALI=$(CURDIR)/build/release/bin/rali tools/demo.sh

PREFIX ?= /usr/local
PACKAGE_TOOLS := dpkg-dev file gzip

share: packages
	cmake --preset release -DRALI_BENCH=OFF
	cmake --build build/release -j $(JOBS) --target rali rali_share

install: share
	cmake --install build/release --prefix $(PREFIX)

deb: share
	@tools/install_packages.sh $(PACKAGE_TOOLS)
	rm -rf build/packages
	cpack --config build/release/CPackConfig.cmake -B build/packages

check-deb: deb
	@tools/install_packages.sh lintian mmdebstrap
	tools/check_deb.sh build/packages/*.deb

bundle: packages
	@tools/install_packages.sh nodejs npm
	cmake --preset release -DRALI_BENCH=OFF
	cmake --build build/release --target rali_bundle

bench: packages
	cmake --preset release -B build/bench -DRALI_BENCH=ON -DRALI_TESTS=OFF
	cmake --build build/bench -j $(JOBS)
	for program in build/bench/bin/bench_*; do "$$program"; done

# The table of this build is build/regression/new.csv; recordings are kept beside it.
regression: release
	mkdir -p build/regression
	rm -f build/regression/new.csv
	/usr/bin/python3 bench/regression/regression.py run --binary build/release/bin/rali --form short \
	  --jobs $(JOBS) --out build/regression/new.csv
	/usr/bin/python3 bench/regression/regression.py compare bench/regression/baseline_short.csv \
	  build/regression/new.csv

fuzz: packages
	@tools/install_packages.sh $(DEV_PACKAGES)
	cmake --preset fuzz
	cmake --build build/fuzz -j $(JOBS)
	tools/run_fuzz.sh build/fuzz/bin $(FUZZ_SECONDS)

asan tsan: packages
	cmake --preset $@
	cmake --build build/$@ -j $(JOBS)
	$(CTEST) --test-dir build/$@

# Vehicles over an emulated bad radio, ten times as long as in the tests (needs root).
soak: release
	RALI_SOAK=1 $(CTEST) --test-dir build/release -L radio -V

format:
	@tools/install_packages.sh $(DEV_PACKAGES)
	$(SOURCES) | xargs clang-format -i

# Formatting, layers, and clang-tidy on what differs from BASE.
BASE ?= HEAD~1
lint: packages
	@tools/install_packages.sh $(DEV_PACKAGES)
	python3 tools/check_layers.py .
	$(SOURCES) | xargs clang-format --dry-run --Werror
	cmake --preset dev
	git diff --name-only --diff-filter=d $(BASE) -- 'src/*.cpp' | xargs -r clang-tidy --quiet -p build/dev

# The pages that are made from the program's own tables; tests compare them.
docs: release
	build/release/bin/rali help-settings > docs/reference/settings.md
	build/release/bin/rali help-cli > docs/reference/cli.md

# What the commands of the tutorials print, written into their pages; a test compares it.
tutorials: release
	for page in $$(grep -l "<!-- tutorial:" docs/*/*.md); do \
	  tools/run_tutorial.py $$page build/release/bin/rali --write; \
	done

# The figures of docs/explain.
figures:
	@tools/install_packages.sh python3-matplotlib python3-numpy
	/usr/bin/python3 tools/explain_figures.py .

# The documents as pages for a browser, without network. Broken links are errors.
site:
	@tools/install_packages.sh mkdocs
	python3 tools/check_docs.py .
	mkdocs build --quiet --strict

clean:
	rm -rf build rali-demo
