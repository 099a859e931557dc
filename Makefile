# Two headers to copy; this file only builds what shows and tests them.
#
#   make demo          the default scene under the default light probe -> build/demo.png
#   make test          everything that CI checks; single tests: build/release/test "words of its name"
#   make               all examples
#   make glsl          renews the GLSL text inside the headers from their C source
#   make bias          computes the safe moment bias per storage format (docs/moments.md quotes it)
#   make bench         speed of the moment math, the map and the probe (docs quote it)
#   make fuzz          random and damaged input for both headers and the file readers, FUZZ_SECONDS=60 each
#   make coverage      lines and branches of the headers' CPU halves that the tests take; fails below 100%
#   make platforms     other compilers, flags, processors and byte orders -> build/platforms.md
#   make mutants       changes the headers' formulas one by one and reports what no test notices
#   make clean
#
# config=debug | release | sanitize | coverage | native, e.g. make test-binary config=debug

config ?= release
out = build/$(config)

WARNINGS = -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror
flags_debug = -O0 -g
flags_release = -O2
flags_sanitize = -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
# Inlined functions would count once for each of their calls.
flags_coverage = -O0 -g --coverage -Dalways_inline=unused
flags_native = -O3 -march=native -ffp-contract=fast
flags_vector = -O3 -march=native -fno-math-errno -fno-trapping-math
flags_m32 = -O2 -m32
CFLAGS ?= $(flags_$(config))
ALL_CFLAGS = -std=c99 $(WARNINGS) -I. $(CFLAGS)
LIBS = -lm -lpthread -ldl
CPU_LIBS = -lm -lpthread

headers = mssm.h lightprobe.h
common_objects = $(patsubst %.c,$(out)/%.o,$(wildcard examples/common/*.c))
common = $(out)/libcommon.a
# Without GLFW `make` leaves the viewer out.
glfw := $(strip $(shell pkg-config --libs glfw3 2>/dev/null))
examples = $(patsubst examples/%.c,$(out)/%,$(filter-out $(if $(glfw),,examples/viewer.c),$(wildcard examples/*.c)))
test_sources = $(filter-out tests/safe_bias.c $(wildcard tests/bench_*.c),$(wildcard tests/*.c))
test_objects = $(patsubst %.c,$(out)/%.o,$(test_sources))
benches = $(patsubst tests/%.c,$(out)/%,$(wildcard tests/bench_*.c))

# The tests of what needs no OpenGL: for coverage, mutants and other platforms.
cpu_sources = $(addprefix tests/,main.c test_moments.c test_map.c test_visibility.c test_lightprobe.c test_edges.c \
    oracle_moments.c oracle_lightprobe.c families.c random.c scenes.c) \
    $(filter-out examples/common/gl_%.c,$(wildcard examples/common/*.c))
cpu_objects = $(patsubst %.c,$(out)/cpu/%.o,$(cpu_sources))

all: $(examples)
	@$(if $(glfw),,echo "viewer left out: apt-get install pkg-config libglfw3-dev")

demo: $(out)/demo
	$(out)/demo --out build/demo.png

test:
	@sh tests/run.sh

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

glsl:
	sh tests/make_glsl.sh $(headers)

bias: $(out)/safe_bias
	$(out)/safe_bias

bench: $(benches)
	@for b in $(benches); do $$b || exit 1; done

clean:
	rm -rf build

$(out)/%.o: %.c $(headers) $(wildcard examples/common/*.h tests/*.h) Makefile
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -c $< -o $@

$(common): $(common_objects)
	@rm -f $@
	$(AR) rcs $@ $^

$(examples): $(out)/%: $(out)/examples/%.o $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/viewer: LIBS += $(glfw)
$(out)/examples/viewer.o: ALL_CFLAGS += $(shell pkg-config --cflags glfw3 2>/dev/null)

$(out)/test: $(test_objects) $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

$(out)/cpu/%.o: %.c $(headers) $(wildcard examples/common/*.h tests/*.h) Makefile
	@mkdir -p $(@D)
	$(CC) $(ALL_CFLAGS) -DTEST_CPU_ONLY -DMSSM_NO_GL -DLIGHTPROBE_NO_GL -c $< -o $@

$(out)/cpu/examples/common/implementation.o: ALL_CFLAGS += $(HEADER_CFLAGS)

$(out)/test-cpu: $(cpu_objects)
	$(CC) $(CFLAGS) $^ -o $@ $(CPU_LIBS)

$(out)/outputs: $(addprefix $(out)/cpu/,tests/platforms/outputs.o examples/common/implementation.o)
	$(CC) $(CFLAGS) $^ -o $@ $(CPU_LIBS)

$(benches) $(out)/safe_bias: $(out)/%: $(out)/tests/%.o $(out)/tests/random.o $(out)/tests/families.o $(common)
	$(CC) $(CFLAGS) $^ -o $@ $(LIBS)

.PHONY: all demo test test-binary test-cpu outputs coverage platforms mutants fuzz glsl bias bench clean
.SECONDARY:
