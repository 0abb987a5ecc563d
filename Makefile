# Two commands do all the set-up on a fresh machine: `make run` and `make test`.
# Needed beforehand: python3 (3.11 or newer, with venv), make and a C library.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
HF     := $(BIN)/hf
BUILD  := build
SOURCES := $(shell find hyperfab -name '*.py' -o -name '*.toml' -o -name '*.csv' -o -name ahead.json)

.DELETE_ON_ERROR:
.PHONY: run study test test-slow test-versions lint types bench blind hunt coverage mutants gaps walks kernels fuzz samples pictures clean distclean help

help:
	@echo "make run     the whole chain on the sample specimens and molds, with a summary and pictures in $(BUILD)/"
	@echo "make study   the sample studies: heaters, chambers and air; foam, gap and temperature"
	@echo "make test    the tests (make test-slow: heavy physics and long fault runs)"
	@echo "make test-versions: the tests with the lowest versions that pyproject.toml allows, and with the newest"
	@echo "make lint    format, lint and import arrows;  make types: the type checker"
	@echo "make bench   timings beside other programs;   make fuzz: readers against random bytes"
	@echo "make blind   undeclared effects drawn at random: how often close-loop names them"
	@echo "make hunt    inputs chosen to break the commands, each judged by an invariance or a known truth"
	@echo "make mutants small defects planted in the program, one at a time: whether a test notices"
	@echo "make kernels the list of kernels that the wheel holds compiled, anew"
	@echo "make clean   remove $(BUILD)/;                 make distclean: remove $(VENV)/ too"

# ---- the environment -------------------------------------------------------------------------------------

$(VENV)/created:
	$(PYTHON) -m venv $(VENV)
	@touch $@

PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check

# The wheel holds its kernels compiled, for the numba that it is then installed with: the same versions for both.
$(VENV)/wheel: export PIP_CONSTRAINT := constraints.txt
$(VENV)/wheel: export PIP_BUILD_CONSTRAINT := constraints.txt
$(VENV)/wheel: $(VENV)/created pyproject.toml setup.py constraints.txt $(SOURCES)
	@rm -rf $@
	$(PIP) wheel --no-deps --wheel-dir $@ .
	@touch $@

# What the program is to have beside it; apart, so that `make -j2` installs it while the kernels are compiled.
$(VENV)/needs.txt: $(VENV)/created pyproject.toml constraints.txt
	sed -nE '/^dependencies/,/^]/s/^ *"([^"]+)".*/\1/p' pyproject.toml > $@
	$(PIP) install --constraint constraints.txt --requirement $@

# The program itself: what a user installs, in the versions of constraints.txt.
$(VENV)/run: $(VENV)/needs.txt $(VENV)/wheel
	$(PIP) install --force-reinstall --no-deps $(VENV)/wheel/*.whl
	$(PIP) install --constraint constraints.txt $(VENV)/wheel/*.whl
	@touch $@

# What the developers' targets need beside it.
$(VENV)/tools.txt: $(VENV)/needs.txt
	sed -nE '/^dev = /,/^]/s/^ *"([^"]+)".*/\1/p' pyproject.toml > $@
	$(PIP) install --constraint constraints.txt --requirement $@

# Tests run the modules that stand here: with the kernels of the wheel, as far as these are the same.
$(VENV)/dev: $(VENV)/run $(VENV)/tools.txt
	@rm -rf hyperfab/compiled
	@cp -r $(VENV)/lib/python3*/site-packages/hyperfab/compiled hyperfab/ || echo "the wheel holds no kernels"
	@touch $@

# ---- the chain: each document is made from the ones before it ------------------------------------------------

TRELOAR := specimens/treloar-1944
LYCRA   := $(wildcard specimens/lycra/*-23C.csv)
HEATED_LYCRA := $(wildcard specimens/lycra/*.csv)
DOCUMENTS := $(addprefix $(BUILD)/, fabric.json case-a.json case-b.json contact.json drape.json \
               heat-original.json heat-proposed.json press.json warp.json loop.json)

run: $(DOCUMENTS) $(BUILD)/report.html
	@$(HF) summary $(DOCUMENTS)
	@echo "page: $(BUILD)/report.html"

# All of it on one page.
$(BUILD)/report.html: $(DOCUMENTS)
	$(HF) report $(DOCUMENTS) -o $@

$(DOCUMENTS): $(VENV)/run | $(BUILD)

$(BUILD):
	@mkdir -p $@

# Chapter 1: the fabric, warp and weft, at room temperature.
$(BUILD)/fabric.json: $(LYCRA)
	$(HF) fit $(addprefix --uniaxial ,$(LYCRA)) --model yeoh-3 -o $@

# Chapter 1, on Treloar's rubber: constants from the uniaxial test alone (case A) and from all tests (case B).
$(BUILD)/case-a.json $(BUILD)/case-b.json: $(wildcard $(TRELOAR)/*.csv)
$(BUILD)/case-a.json: FIT_ON := --fit-on uniaxial
$(BUILD)/case-a.json $(BUILD)/case-b.json:
	$(HF) fit --uniaxial $(TRELOAR)/uniaxial.csv --shear $(TRELOAR)/shear.csv --biaxial $(TRELOAR)/biaxial.csv \
	  --model yeoh-3 $(FIT_ON) -o $@

# Chapter 2: the sphere on the membrane judges case A against case B.
$(BUILD)/contact.json: $(BUILD)/case-a.json $(BUILD)/case-b.json
	$(HF) fabric-contact $(BUILD)/case-a.json --against $(BUILD)/case-b.json --shape disc --size 200mm --thickness "1mm +- 0.02mm" \
	  --sphere-radius 40mm --depth 60mm -o $@

# Chapter 3: the fabric on the cup.
$(BUILD)/drape.json: $(BUILD)/fabric.json molds/cup-male.stl
	$(HF) drape $< --mold molds/cup-male.stl --grid 100x100 --size 220mmx220mm --depth 60mm -o $@

# Chapter 4: two designs of the heated mold.
$(BUILD)/heat-%.json: molds/%.toml specimens/film.csv
	$(HF) mold-heat $< -o $@

# Chapter 5: the hot molds on the foam sandwich, with the fabric as draped.
$(BUILD)/press.json: $(BUILD)/drape.json specimens/foam.toml specimens/foam.csv molds/cup-male.stl molds/cup-female.stl
	$(HF) press-contact --male molds/cup-male.stl --female molds/cup-female.stl --axis z \
	  --foam specimens/foam.toml --gap "3mm +- 0.1mm" --temperature "200degC +- 5K" --drape $(BUILD)/drape.json -o $@

# Chapter 6: what constants from the warp at room temperature lack, judged by the tests across and at 80 and 105 degC.
$(BUILD)/warp.json: specimens/lycra/warp-23C.csv
	$(HF) fit --uniaxial $< --model yeoh-3 -o $@

$(BUILD)/loop.json: $(BUILD)/warp.json $(HEATED_LYCRA)
	$(HF) close-loop $< $(addprefix --measured ,$(HEATED_LYCRA)) -o $@

# ---- the sample studies: many runs, each finished one kept -----------------------------------------------------

study: $(VENV)/run | $(BUILD)
	$(HF) sweep molds/study-heat.toml --out $(BUILD)/study-heat
	$(HF) sweep molds/study-press.toml --out $(BUILD)/study-press
	@$(HF) summary $(BUILD)/study-heat/sweep.json $(BUILD)/study-press/sweep.json

# ---- the net under it ---------------------------------------------------------------------------------------

test: $(VENV)/dev
	$(BIN)/python -m pytest -n auto --dist worksteal

test-slow: $(VENV)/dev
	$(BIN)/python -m pytest -m slow

# The lowest version of everything that pyproject.toml allows, and the newest that the index has, on the oldest and the
# newest Python: a quarter of an hour each.
OLDEST ?= python3.11
NEWEST ?= python3.13
VERSIONS := $(BUILD)/versions

test-versions: $(VERSIONS)/lowest/dev $(VERSIONS)/newest/dev
	$(VERSIONS)/lowest/bin/python -m pytest -n auto
	$(VERSIONS)/newest/bin/python -m pytest -n auto

$(VERSIONS)/lowest.txt: pyproject.toml
	@mkdir -p $(@D)
	sed -nE '/^dependencies/,/^]/s/^ *"([a-z0-9-]+)>=([0-9.]+)[";].*/\1==\2/p' $< > $@

$(VERSIONS)/newest.txt: pyproject.toml
	@mkdir -p $(@D)
	touch $@

$(VERSIONS)/lowest/dev: OF := $(OLDEST)
$(VERSIONS)/newest/dev: OF := $(NEWEST)
$(VERSIONS)/%/dev: $(VERSIONS)/%.txt
	$(OF) -m venv $(@D)
	$(@D)/bin/python -m pip install --quiet --disable-pip-version-check --upgrade --constraint $< --editable '.[dev]'
	@touch $@

lint: $(VENV)/tools.txt
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/lint-imports

# All of it for Linux; for the others what imports a module of the standard library whose types ask for the system.
# Other modules are not followed there; the three options pass over what comes of that alone.
STUBS = $$($(BIN)/python -c 'import mypy; print(mypy.__path__[0])')/typeshed/stdlib

types: $(VENV)/tools.txt
	@asking=$$(grep -rl sys.platform $(STUBS) | sed 's|.*/stdlib/||; s|[/.].*||' | sort -u | paste -sd '|'); \
	 (echo linux --num-workers 2; for system in win32 darwin; do echo $$system --follow-imports skip \
	   --no-warn-unused-ignores --allow-subclassing-any --disable-error-code var-annotated \
	   $$(grep -lrE "^\s*(import|from) ($$asking)\b" --include=*.py hyperfab); done) \
	   | xargs -P 3 -L 1 sh -c '$(BIN)/mypy --cache-dir .mypy_cache/$$0 --platform $$0 "$$@"'

bench: $(VENV)/dev
	@for script in benchmarks/*.py; do echo "== $$script"; $(BIN)/python $$script || exit 1; done

# Effects that nobody declares, drawn at random: how often the loop names them. BLIND is how many of each for a fabric:
# 20 for the tables in docs/close-loop.md (a quarter of an hour more).
BLIND ?= 6
BLIND_TWO ?= 2

blind: $(VENV)/dev
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind fabric $(BLIND)
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind fabric $(BLIND) --other
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind fabric $(BLIND) --third
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind fabric $(BLIND) --poor --next hysteresis mullins rate permanent-set grip-slack load-offset elastic-law none
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind fabric $(BLIND_TWO) --two
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_heat 2 rich
	for domain in press contact drape; do PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_$$domain 2 rich || exit 1; done
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_press 1 film --next
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_press 2 hot foam-softening none
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_press 2 opened set none
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_press 2 gauged tilt lateral-shift
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_contact 2 poor --next
	PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m loop.blind_drape 2 poor --next

# One command: make hunt HUNTS=fit.
HUNTS ?= $(patsubst trials/hunt_%.py,%,$(wildcard trials/hunt_*.py))

hunt: $(VENV)/dev
	@for hunt in $(HUNTS); do echo "== $$hunt"; PYTHONPATH=.:tests OMP_NUM_THREADS=1 $(BIN)/python -m trials.hunt_$$hunt || exit 1; done

# How often 95 % intervals of hf fit, and those of forces that are foretold from it, hold the truth, and what it says of
# tests it has not seen: about a quarter of an hour.
coverage: $(VENV)/dev
	PYTHONPATH=. $(BIN)/python -m trials.coverage 100
	PYTHONPATH=. $(BIN)/python -m trials.coverage_force 400
	PYTHONPATH=. $(BIN)/python -m trials.foretold 400
	PYTHONPATH=. OMP_NUM_THREADS=1 $(BIN)/python -m trials.linear_heat
	PYTHONPATH=. $(BIN)/python -m trials.unseen 3

# How many modules a stretch, a temperature and a reading meet on their way, as CONTRIBUTING.md tells.
walks: $(VENV)/dev
	PYTHONPATH=. $(BIN)/python -m trials.walks

# Some two hundred defects, half an hour of one core for them and as long before it to see which test reaches what; both
# are kept in $(BUILD)/mutants, and only what changed is done again.
mutants: $(VENV)/dev
	OMP_NUM_THREADS=1 $(BIN)/python -m trials.mutants

# Gaps of molds with bosses, pits, folds and bumps, drawn at random, by trying every facet.
GAPS ?= 10000

gaps: $(VENV)/dev
	PYTHONPATH=.:tests $(BIN)/python -m rough_molds $(GAPS)

# Which kernels the commands call, with which types: hyperfab/ahead.json, what the wheel holds compiled. Five minutes.
kernels: $(VENV)/dev
	$(BIN)/python -m trials.kernels

fuzz: $(VENV)/dev
	HYPOTHESIS_PROFILE=fuzz $(BIN)/python -m pytest tests/io tests/documents

# Write the shipped samples anew; a test holds them equal to what `hf sample` makes.
samples: $(VENV)/run
	$(HF) sample . --force

# The pictures of README.md, from the chain's own.
pictures: $(DOCUMENTS)
	@mkdir -p docs/images
	cp $(BUILD)/case-b.png docs/images/fit.png
	cp $(BUILD)/contact.png $(BUILD)/drape.png $(BUILD)/heat-proposed.png $(BUILD)/press.png $(BUILD)/loop.png docs/images/

clean:
	rm -rf $(BUILD)

distclean: clean
	rm -rf $(VENV)
