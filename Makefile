# sss_resample.h: plain `make` lists what there is.
CC       ?= cc
CXX      ?= c++
STRICT   := -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wundef -Werror
# -ffp-contract=off: the same bits on every machine. The others let loops over sqrtf vectorise.
EXACT    := -ffp-contract=off -fno-math-errno -fno-trapping-math
FONT     ?= /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf
CFLAGS   ?= -O2 -march=native
DEMO_C    = $(CC) -std=c99 $(CFLAGS) $(EXACT) $(STRICT) -fopenmp -I.
TEST_C   := $(CC) -std=c99 $(CFLAGS) $(EXACT) $(STRICT) -fopenmp -I. -Itests -DDATA_DIR='"tests/data"'
CL_C     := -Ibuild cl/sss_cl.c
COMMON   := $(wildcard demos/common/*.h) sss_resample.h
STUDY    := $(wildcard demos/study/*.h) $(COMMON)
CL       := cl/sss_cl.c cl/sss_cl.h build/sss_cl_source.h build/tracer_cl_source.h
WINDOW   := -lglfw -ldl
PREFIX   ?= /usr/local

PACKAGES := gcc g++ clang libc6-dev perl libcmocka-dev libstb-dev fonts-dejavu-core gnuplot-nox ocl-icd-opencl-dev \
    pocl-opencl-icd oclgrind libglfw3-dev libosmesa6 libgl-dev xvfb xdotool pandoc libembree-dev libassimp-dev \
    assimp-testmodels
LONG     := gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc-s390x-linux-gnu libc6-dev-s390x-cross gcc-i686-linux-gnu \
    libc6-dev-i386-cross gcc-mingw-w64-x86-64 libclang-rt-dev qemu-user chromium lld nodejs cmake pkg-config parallel \
    python3-pandas python3-matplotlib
# Without Embree 3 and assimp all but these four are built.
HAS_MESH := $(CC) -E -x c -include embree3/rtcore.h -include assimp/cimport.h /dev/null >/dev/null 2>&1
NO_MESH  := $(shell $(HAS_MESH) || echo build/mesh build/mesh_race build/mesh_share build/test_mesh)
DEMOS    := $(filter-out $(NO_MESH),$(patsubst %.c,build/%,$(notdir $(wildcard demos/*.c demos/study/*.c))))
# The promises of the library come first. T=contract selects test_contract, T="mesh render" several.
FIRST    := contract bound intensity profiles math random plans invariance robust extremes failures fuzz opencl
SOURCES  := $(FIRST:%=tests/test_%.c) $(filter-out $(FIRST:%=tests/test_%.c),$(wildcard tests/test_*.c))
PROGRAMS := $(filter-out $(NO_MESH),$(patsubst tests/%.c,build/%,$(SOURCES)))
# The page's and the windows' tests wait for most of their time, so they come before all.
ORDER    := tests/test_page.sh tests/test_window.sh $(filter $(FIRST:%=build/test_%),$(PROGRAMS)) tests/test_tutorial.sh tests/test_chart.sh tests/test_compile.sh
EACH     := $(ORDER) $(filter-out $(ORDER),$(PROGRAMS) $(wildcard tests/test_*.sh)) $(if $(filter run-test-long,$(MAKECMDGOALS)),$(wildcard tests/long/test_*.sh))
TESTS    := $(if $(T),$(filter $(foreach t,$(T),%/test_$t %/test_$t.sh),$(EACH)),$(EACH))
TOOLS    := build/tools/pfm build/tools/pixels
EXAMPLES := $(patsubst examples/%.c,build/examples/%,$(wildcard examples/*.c))
CHAPTERS := $(patsubst tutorial/%/main.c,build/tutorial/%,$(wildcard tutorial/*/main.c))
CHARTS   := race which hints model mesh
# With pandas and matplotlib, as make setup-long installs them for this one.
PYTHON   ?= /usr/bin/python3
FUZZ_MINUTES ?= 1

.PHONY: help setup setup-long all mesh has-mesh demo pictures measure test-pictures test test-long run-test run-test-long test-mutants test-table fuzz coverage \
    mix tile chart which-model model-error failures bench tutorial install clean
help:
	@echo 'make setup         install what is missing, from Debian packages (as root or through sudo)'
	@echo 'make demo          render a rabbit by five methods in the same time: build/demo.png;'
	@echo '                   then noise against resampling, in a window or as build/noise.png'
	@echo 'make mesh          build/mesh FILE makes any mesh translucent: needs Embree and assimp, see make setup'
	@echo 'make measure       measure anew what the READMEs quote, and fill it in (5 minutes)'
	@echo 'make pictures      the same, and the pictures of the READMEs but for those of make chart'
	@echo 'make test          build the tests and run them, 3 to 4 minutes; T=contract runs that one alone'
	@echo 'make test-long     more of each, exhaustive sweeps, other processors and compilers (make setup-long first)'
	@echo 'make test-mutants  plant bugs in the header; the tests must find each of them'
	@echo 'make test-table    fill the figures of tests/README.md from the last make test'
	@echo 'make fuzz          hostile bytes for FUZZ_MINUTES (1), under sanitizers (make setup-long first)'
	@echo 'make coverage      lines and branches of the header that the tests reach'
	@echo 'make mix           the experiment that chose the default mix of techniques'
	@echo 'make tile          the experiment behind sharing: its spacing rule, tile, candidates and colours (5 minutes)'
	@echo 'make chart         speed against accuracy of all methods, drawn: build/chart-*.png (8 minutes; make setup-long first)'
	@echo 'make which-model   the map of models that sss_plan_for chooses from, drawn'
	@echo 'make model-error   how far a flat profile is off from the volume, and whether the plan knows: drawn (about 3 minutes)'
	@echo 'make failures      ten ways to sample that fail, each beside the header: build/failures.html (about 2 minutes)'
	@echo 'make bench         what a candidate costs; lookups a second on the CPU and on an OpenCL device'
	@echo 'make tutorial      run the programs of tutorial/ and make its figures, listings and numbers anew'
	@echo 'make page          the tutorial as one page with live figures: build/page/index.html (make setup-page first)'
	@echo 'make all           build every program into build/'
	@echo 'make install       the header to PREFIX/include ($(PREFIX)), and what CMake and pkg-config find it by'
	@echo 'make clean         remove build/'

# Only what is missing is installed, so that a second run takes no time.
setup setup-long:
	@missing=''; for p in $(PACKAGES) $(if $(filter setup-long,$@),$(LONG)); do \
	    dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || missing="$$missing $$p"; done; \
	[ -z "$$missing" ] && { echo 'setup: all packages are here'; exit 0; }; \
	sudo=''; [ "$$(id -u)" = 0 ] || sudo=sudo; \
	echo "setup: installing$$missing"; \
	$$sudo apt-get -q update && $$sudo env DEBIAN_FRONTEND=noninteractive apt-get -q -y --no-install-recommends install $$missing

all: $(DEMOS)

build:
	@mkdir -p build

# Texts for OpenCL, inside the programs: these run from any folder.
EMBED     = cl/embed.sh $(basename $(@F)) $(filter-out cl/embed.sh,$^) > $@ || { rm -f $@; exit 1; }

build/sss_cl_source.h: cl/embed.sh sss_resample.h | build
	$(EMBED)

build/tracer_cl_source.h: cl/embed.sh demos/common/scene.h demos/common/tracer.h demos/common/tracer.cl | build
	$(EMBED)

build/layout_source.h: cl/embed.sh tests/layout.h | build
	$(EMBED)

build/render: demos/render.c $(COMMON) $(CL)
	$(DEMO_C) -DFONT_FILE='"$(FONT)"' $< $(CL_C) -o $@ -lOpenCL -lstb -lm

build/exit_points: demos/exit_points.c $(COMMON) | build
	$(DEMO_C) -DFONT_FILE='"$(FONT)"' $< -o $@ $(WINDOW) -lstb -lm

build/noise: demos/noise.c $(COMMON) $(CL)
	$(DEMO_C) -DFONT_FILE='"$(FONT)"' $< $(CL_C) -o $@ $(WINDOW) -lOpenCL -lstb -lm

mesh: build/mesh

has-mesh:
	@$(HAS_MESH) || { echo 'Embree 3 or assimp is missing; make setup installs both'; exit 1; }

build/mesh: demos/mesh.c $(COMMON) | build has-mesh
	$(DEMO_C) -DFONT_FILE='"$(FONT)"' $< -o $@ $(WINDOW) -lembree3 -lassimp -lstb -lm

$(filter-out build/bench_exits build/mesh_race build/mesh_share,$(patsubst demos/study/%.c,build/%,$(wildcard demos/study/*.c))): build/%: demos/study/%.c $(STUDY) | build
	$(DEMO_C) $< -o $@ -lstb -lm

build/mesh_race build/mesh_share: build/%: demos/study/%.c demos/study/torus.h $(COMMON) | build has-mesh
	$(DEMO_C) $< -o $@ -lembree3 -lm

# The header's own code is a quarter faster with -O3, the demos' is not.
build/bench build/bench_exits build/chart build/mesh_race build/mesh_share: CFLAGS += -O3

build/bench_exits: demos/study/bench_exits.c $(COMMON) $(CL)
	$(DEMO_C) $< $(CL_C) -o $@ -lOpenCL -lm

build/test_mesh: tests/test_mesh.c tests/sss_test.h $(COMMON) | build
	$(TEST_C) $< -o $@ -lembree3 -lcmocka -lm

build/test_opencl: tests/test_opencl.c tests/sss_test.h tests/layout.h $(COMMON) $(CL) build/layout_source.h
	$(TEST_C) $< $(CL_C) -o $@ -lOpenCL -lcmocka -lm

build/test_tiles: tests/test_tiles.c tests/sss_test.h $(COMMON) | build
	$(TEST_C) $< -o $@ -lcmocka -lm

build/test_rivals: tests/test_rivals.c tests/sss_test.h $(STUDY) | build
	$(TEST_C) $< -o $@ -lcmocka -lm

build/test_plan_model: demos/study/model_bodies.h

$(EXAMPLES): build/examples/%: examples/%.c examples/renderer.h sss_resample.h
	@mkdir -p $(@D)
	$(CC) -std=c99 -O1 $(EXACT) $(STRICT) -I. -Iexamples $< -o $@ -lm

# A chapter's program is built by the command that the chapter prints, into a folder of its own.
$(CHAPTERS): build/tutorial/%: tutorial/%/main.c tutorial/%/README.md $(wildcard tutorial/*.h) sss_resample.h
	@mkdir -p $(@D)
	sed -n 's|^\(cc .* -o build/\)|\1tutorial/|p' tutorial/$*/README.md | head -n 1 | sh -ex

build/tools/%: tests/tools/%.c
	@mkdir -p $(@D)
	$(CC) -std=c99 -D_POSIX_C_SOURCE=200809L -O1 $(STRICT) $< -o $@ $(if $(filter %/x11,$@),-lX11,-lstb) -lm

# The fuzzer, with the sanitizers that find what a wrong result does not show.
build/fuzz: SANITIZERS := address,undefined,float-divide-by-zero,float-cast-overflow
build/fuzz_memory: SANITIZERS := memory
build/fuzz build/fuzz_memory: tests/fuzz.c tests/fuzz_ignore.txt sss_resample.h | build
	clang -std=c99 -O2 -g $(EXACT) $(STRICT) -fno-sanitize-recover=all -fsanitize-ignorelist=tests/fuzz_ignore.txt \
	    -fsanitize=fuzzer,$(SANITIZERS) -I. $< -o $@ -lm

build/test_walk: $(STUDY)
build/test_fuzz: tests/fuzz.c
build/test_%: tests/test_%.c tests/sss_test.h sss_resample.h | build
	$(TEST_C) $< -o $@ -lcmocka -lm

# Seed 2: with seed 1 a few fireflies triple the error of plain probes, and flatter the others.
demo: build/render build/noise
	build/render --compare --scene rabbit --size 300x360 --seed 2 --png build/demo.png
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then build/noise; else build/noise --headless --png build/noise.png; fi

pictures: build/exit_points failures which-model measure
	cp build/failures.png build/failures-four.png demos/study/
	build/exit_points --headless --png demos/exit_points.png

# What the programs print is kept, and fills the figures of the three pages that quote it.
KEPT := demos/study/measured
PRINTED := rabbit share_noise mix model_error mesh_share bench
measure: build/render build/share_noise build/mix build/mesh_share build/bench build/bench_exits model-error
	build/render --compare --scene rabbit --size 300x360 --seed 2 --png build/rabbit.png >build/rabbit.txt
	build/share_noise build/share.png >build/share_noise.txt
	build/mix >build/mix.txt
	build/mesh_share >build/mesh_share.txt
	(build/bench && POCL_CACHE_DIR=build/pocl build/bench_exits) >build/bench.txt
	cp $(PRINTED:%=build/%.txt) $(KEPT)/
	cp build/rabbit.png demos/
	cp build/share.png demos/study/
	demos/study/quote.sh README.md demos/study/README.md examples/README.md

# What tests/test_window.sh compares with. Look at it before it is kept.
test-pictures: build/exit_points build/noise
	build/exit_points --headless --size 480x270 --png tests/data/exit_points.png
	build/noise --headless --size 320x180 --spp 2 --reference 4 --png tests/data/noise.png

bench: build/bench build/bench_exits
	build/bench
	@mkdir -p build/pocl
	POCL_CACHE_DIR=build/pocl build/bench_exits

mix: build/mix
	build/mix

tile: build/tile
	build/tile

model-error: build/model_error
	build/model_error build/model_error.dat >build/model_error.txt
	cat build/model_error.txt
	gnuplot -e "out='build/model_error'" demos/study/model_error.gp
	cp build/model_error.png demos/study/

# Rows that build/chart.csv holds are not measured again. REDUCED=1 does an eighth.
chart: build/chart build/model build/mesh_race
	build/chart $(if $(REDUCED),--reduced)
	build/mesh_race $(if $(REDUCED),--reduced) >build/chart-mesh.new
	mv build/chart-mesh.new build/chart-mesh.csv
	build/model tests/data/mc_searchlight.csv build/chart
	$(PYTHON) demos/study/chart.py build/chart.csv build/chart-model.dat build/chart-mesh.csv build/chart
	cp build/chart.csv build/chart-mesh.csv build/chart.md build/chart-caption.md $(CHARTS:%=build/chart-%.png) demos/study/

which-model: build/which_model
	build/which_model >build/which_model.dat
	gnuplot -e "out='build/which_model'" demos/study/which_model.gp
	cp build/which_model.png demos/study/

failures: build/failures
	build/failures build/failures >build/failures.csv
	gnuplot -e "out='build/failures'" demos/study/failures.gp

# What the chapters show comes from what their programs do; tests/test_tutorial.sh compares.
tutorial:
	tutorial/make.sh

# ---- The live page: the tutorial's text, and figures that the header drives, as WebAssembly.
.PHONY: page page-stills setup-page drawings
PAGE := clang lld pandoc webp python3 chromium chromium-driver

setup-page:
	@$(MAKE) --no-print-directory setup PACKAGES='$(PAGE)'

page: | build
	tutorial/page/build.sh

drawings:
	python3 tutorial/drawings/draw.py

page-stills: page
	python3 tutorial/page/stills.py

# Figure 7 as a native program, for tests/page.py: its mean has the same bits.
build/page/figures: tutorial/page/figures.c sss_resample.h
	@mkdir -p build/page
	$(CC) -std=c99 -O2 $(EXACT) $(STRICT) -DNATIVE -I. $< -o $@

# All that can be built is built first, on all cores: with -j on the whole, `make setup test` would
# not wait for setup. Each test has one core, and tests run side by side, one more than there are
# cores: some wait for windows. What they have measured is kept in build/logs.
NEEDED   := $(if $(filter %.sh,$(TESTS)),all $(TOOLS) $(EXAMPLES) $(CHAPTERS)) $(filter build/%,$(TESTS))
test test-long:
	@$(MAKE) --no-print-directory run-$@

# A make of its own: it sees what `make setup test` has installed a moment before.
run-test run-test-long:
	@[ "$(TESTS)" ] || { echo 'make $(@:run-%=%): there is no test of the name $(T)'; exit 2; }
	@failed=; $(MAKE) --no-print-directory -k -j $$(nproc) $(NEEDED) || failed=1; \
	BUILD=build OMP_NUM_THREADS=1 prove -j $$(($$(nproc) + 1)) --directives --failures --comments -e tests/run.sh \
	    $(TESTS) $(if $(filter run-test-long,$@),:: --long) || failed=1; \
	[ -z "$$failed" ] || { echo 'make $(@:run-%=%): not all could be built and passed'; exit 1; }

test-table:
	@BUILD=build tests/table.sh

# A crash is kept as build/crash-*.
fuzz:
	FUZZ_SECONDS=$$(($(FUZZ_MINUTES) * 60)) bash tests/long/test_sanitize.sh

coverage:
	@bash tests/coverage.sh

test-mutants: test
	@BUILD=build bash tests/mutants.sh

# The header, and what lets CMake and pkg-config find it; CMakeLists.txt installs the same.
VERSION   = $(shell sed -n '1s/.* v\([0-9.]*\) .*/\1/p' sss_resample.h)
SHARE     = $(DESTDIR)$(PREFIX)/share
install: | build
	@for file in sss_resample.pc sss_resampleConfigVersion.cmake; do \
	    sed 's/@VERSION@/$(VERSION)/' cmake/$$file.in > build/$$file || exit 1; done
	install -D -m 644 -t "$(DESTDIR)$(PREFIX)/include" sss_resample.h
	install -D -m 644 -t "$(SHARE)/pkgconfig" build/sss_resample.pc
	install -D -m 644 -t "$(SHARE)/cmake/sss_resample" cmake/sss_resampleConfig.cmake build/sss_resampleConfigVersion.cmake

clean:
	rm -rf build
