# Two headers to copy; this file only builds what shows and tests them.
#
#   make demo          the default scene under the default light probe -> build/demo.png
#   make test          the tests, in some minutes; single ones: build/release/test "words of its name"
#   make test-all      all trials, compilers, sanitizers and drivers, as CI does (half an hour)
#   make examples      all examples into build/release; also what plain `make` does
#   make glsl          renews the GLSL text inside the headers from their C source
#   make bias          proves the safe moment bias per storage format; fails where mssm.h has less
#   make specular      fits the numbers of lightprobe.h's specular reflection; fails where it has others
#   make stability     where moment methods fail, ours and others: docs/stability.md (some minutes)
#   make bench         speed of the moment math, the map, the probe and the governor's ladder
#   make chart         speed against accuracy, all methods: docs/accuracy.md, its pictures and figures
#   make chart-quick   the same from fewer receivers, into build/docs
#   make chart-check   whether README and docs still say what the figures say
#   make figures       the papers' figures re-made: docs/figures.md and its pictures (some minutes; optipng, if
#                      there, makes those a fifth smaller)
#   make page          the hello scene and the demo's, live in WebGL 2: build/page/page.html (emscripten)
#   make isa           what GPUs execute of the shaders, counted in their machine code: docs/gpu.md
#   make fuzz          random and damaged input for both headers and the file readers, FUZZ_SECONDS=60 each
#   make coverage      lines and branches of the headers' CPU halves that the tests take; fails below 100%
#   make platforms     other compilers, flags, processors and byte orders -> build/platforms.md
#   make mutants       changes the headers' formulas one by one and reports what no test notices
#   make clean
#
# config=debug | release | sanitize | coverage | native ..., e.g. make test-binary config=debug

config ?= release
out = build/$(config)

WARNINGS = -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror
flags_debug = -O0 -g
flags_release = -O2
flags_sanitize = -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
# Inlined functions would count once for each of their calls.
flags_coverage = -O0 -g --coverage -DNO_THREADS -Dalways_inline=unused
flags_native = -O3 -march=native -ffp-contract=fast
flags_vector = -O3 -march=native -fno-math-errno -fno-trapping-math
flags_m32 = -O2 -m32 -msse2 -mfpmath=sse
# Numbers as the 8087 rounds them.
flags_x87 = -O2 -mfpmath=387
CFLAGS ?= $(flags_$(config))
ALL_CFLAGS = -std=c99 $(WARNINGS) -I. $(CFLAGS)
LIBS = -lm -lpthread -ldl
CPU_LIBS = -lm -lpthread

headers = mssm.h lightprobe.h
common_objects = $(patsubst %.c,$(out)/%.o,$(wildcard examples/common/*.c))
common = $(out)/libcommon.a
# Without GLFW `make` leaves the viewer out.
glfw := $(strip $(shell pkg-config --libs glfw3 2>/dev/null))
examples = $(patsubst examples/%.c,$(out)/%,$(filter-out examples/page.c $(if $(glfw),,examples/viewer.c),$(wildcard examples/*.c)))
# tests/suites.h lists the suites; what they stand on is in tests/support.
suites = $(shell sed -nE 's,^($(1))\(([a-z]+)\, ([a-z_]+)\)$$,tests/\2/test_\3.c,p' tests/suites.h)
test_sources = $(call suites,CPU|ALL|GL64) $(wildcard tests/support/*.c tests/gl/gl_*.c)
# tests/compare holds the rivals, which the tests use too, and three programs: report and pictures with
# files of their own, and measure, which is all the others.
programs = $(patsubst %.c,$(out)/%.o,$(filter-out tests/$(1)/test_%,$(wildcard tests/$(1)/*.c)))
support = $(patsubst %,$(out)/tests/support/%.o,$(1))
compare = $(call programs,compare)
part = $(patsubst %,$(out)/tests/compare/%.o,$(1))
rivals = $(call part,methods patterns percentage_closer variance convolution mip_maps)
report_only = $(call part,report charts page claims summary svg)
report_objects = $(filter $(report_only) $(call part,figures),$(compare))
measure_objects = $(filter-out $(report_only) $(call part,pictures),$(compare))
test_objects = $(patsubst %.c,$(out)/%.o,$(test_sources)) $(rivals) $(call part,cases cases_new flip gl_convolution gl_percentage_closer measure_gl figures light_cuts) \
    $(out)/tests/isa/listing.o $(out)/tests/figures/median_cut.o $(out)/tests/figures/gl_median_cut.o
stability_objects = $(call programs,stability) $(call part,svg) $(call support,families oracle_moments oracle_lightprobe scenes random)
benches = $(patsubst tests/bench/%.c,$(out)/%,$(wildcard tests/bench/*.c))

# The tests of what needs no OpenGL: for coverage, mutants and other platforms.
cpu_sources = $(call suites,CPU) $(filter-out tests/support/gl_%,$(wildcard tests/support/*.c)) \
    $(filter-out examples/common/gl%.c,$(wildcard examples/common/*.c))
cpu_objects = $(patsubst %.c,$(out)/cpu/%.o,$(cpu_sources))

all: examples

examples: $(examples)
	@$(if $(glfw),,echo "viewer left out: apt-get install pkg-config libglfw3-dev")

demo: $(out)/demo
	$(out)/demo --out build/demo.png

test:
	@sh tests/run.sh

test-all:
	@sh tests/run.sh all

test-binary: $(out)/test

test-cpu: $(out)/test-cpu

outputs: $(out)/outputs

coverage:
	@sh tests/coverage.sh

fuzz:
	@sh tests/fuzz.sh

platforms:
	@sh tests/platforms.sh

mutants:
	@sh tests/mutants.sh

isa:
	@sh tests/isa.sh write

$(out)/isa: $(call programs,isa) $(call part,gl_convolution gl_percentage_closer patterns figures) $(common)
	$(CC) $(CFLAGS) $^ -o $@ -lvulkan $(LIBS)

glsl:
	sh tests/make_glsl.sh $(headers)

bias: $(out)/safe_bias
	$(out)/safe_bias

specular: $(out)/specular
	$(out)/specular

stability: $(out)/stability
	$(out)/stability

bench: $(benches)
	@for b in $(benches); do $$b || exit 1; done

# The bounds over arrays need flags that let the compiler vectorise.
measure_all = $(out)/measure $(1) --out build/accuracy.csv && \
	build/vector/measure $(1) --only array --append --out build/accuracy.csv

measure-vector:
	$(MAKE) config=vector build/vector/measure

chart: $(out)/measure $(out)/report $(out)/pictures measure-vector
	$(call measure_all,)
	cp build/accuracy.csv docs/accuracy.csv
	$(out)/report docs/accuracy.csv --docs docs
	$(out)/pictures docs/methods_demo.png "demo scene" 0.25 0.3 3.1 6.6 0 0.75 0.3
	$(out)/pictures docs/methods_grids.png grids 0.25 1.5 2.6 4.6 -0.1 0.35 0.2

chart-quick: $(out)/measure $(out)/report measure-vector
	$(call measure_all,--quick)
	@mkdir -p build/docs
	$(out)/report build/accuracy.csv --docs build/docs

chart-check: $(out)/report
	$(out)/report docs/accuracy.csv --check README.md docs/*.md

figures: $(out)/figures
	$(out)/figures docs
	@! command -v optipng >/dev/null || optipng -quiet -o2 docs/figure_*.png

# The page is one file. Node of others than Debian does not find Debian's acorn by itself.
page_sources = examples/page.c $(filter-out examples/common/gl_%.c,$(wildcard examples/common/*.c))
build/page/page.html: $(page_sources) examples/page.html $(headers) $(wildcard examples/common/*.h) Makefile
	@mkdir -p $(@D)
	NODE_PATH=/usr/share/nodejs emcc -std=gnu99 -O2 -Wall -Wextra -Werror -DNO_THREADS -I. $(page_sources) -o $@ \
	    --shell-file examples/page.html -sMIN_WEBGL_VERSION=2 -sMAX_WEBGL_VERSION=2 -sSINGLE_FILE=1 \
	    -sALLOW_MEMORY_GROWTH=1 -sMINIFY_HTML=0 || { rm -f $@; exit 1; }

page:
	@if command -v emcc >/dev/null; then $(MAKE) build/page/page.html; else echo "page left out: apt-get install emscripten"; fi

clean:
	rm -rf build

$(out)/%.o: %.c $(headers) $(wildcard examples/common/*.h tests/*.h tests/*/*.h) Makefile
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -c $< -o $@

# Holds both headers once more; what it fakes needs no speed.
$(out)/tests/support/gl_fakes.o: ALL_CFLAGS += -O1

# Tests that hold the example itself.
$(out)/tests/examples/test_catcher.o: examples/gl_catcher.c
$(out)/tests/examples/test_gl_room.o: examples/gl_room.c

$(common): $(common_objects)
	@rm -f $@
	$(AR) rcs $@ $^

$(examples): $(out)/%: $(out)/examples/%.o $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/viewer: LIBS += $(glfw)
$(out)/examples/viewer.o: ALL_CFLAGS += $(shell pkg-config --cflags glfw3 2>/dev/null)

$(out)/test: $(test_objects) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/dialects: $(out)/tests/dialects/dialects.o $(call support,random) $(common)
$(out)/compare_pictures: $(out)/tests/dialects/compare.o $(common)
$(out)/dialects $(out)/compare_pictures:
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/stability: $(stability_objects) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/specular: $(out)/tests/proofs/specular.o $(call support,random) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/safe_bias: $(out)/tests/proofs/safe_bias.o $(call support,oracle_moments random families) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(benches): $(out)/%: $(out)/tests/bench/%.o $(call support,random families) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/measure: $(measure_objects) $(call support,random oracle_lightprobe) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/pictures: $(call part,pictures cases cases_new flip) $(rivals) $(call support,random) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/figures: $(call programs,figures) $(rivals) $(call part,svg gl_convolution gl_percentage_closer) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/report: $(report_objects) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/cpu/%.o: %.c $(headers) $(wildcard examples/common/*.h tests/*.h tests/*/*.h) Makefile
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -DTEST_CPU_ONLY -DMSSM_NO_GL -DLIGHTPROBE_NO_GL -c $< -o $@

$(out)/cpu/examples/common/implementation.o: ALL_CFLAGS += $(HEADER_CFLAGS)
ifdef HEADER_CC
$(out)/cpu/examples/common/implementation.o: override CC = $(HEADER_CC)
endif

$(out)/test-cpu: $(cpu_objects)
	$(CC) $(CFLAGS) $^ -o $@ $(CPU_LIBS)

$(out)/outputs: $(addprefix $(out)/cpu/,tests/platforms/outputs.o examples/common/implementation.o)
	$(CC) $(CFLAGS) $^ -o $@ $(CPU_LIBS)

.PHONY: page all examples demo test test-all test-binary test-cpu outputs coverage platforms mutants fuzz isa glsl bias specular stability bench chart figures \
    chart-quick chart-check clean measure-vector
.SECONDARY:
