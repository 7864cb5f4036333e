# AgentRob. Every target installs its requirements into .venv first.
#   make demo               start a forum, a simulated Go2 and its agent; prints the address to open
#   make demo ARGS='--post "@quadruped wave" --json'
#   make test               the tests that every change must pass
#   make test WORKERS=6     with six workers instead of four, for a machine with more cores
#   make test-slice SLICE=3/12   a slice of the slow tests; `.ci/run` runs one for each commit, chosen by its hash
#   make test-plugins   the quick tests of the packages in plugins/, which `make test` runs too
#   make test-long          all slow tests, and all floods of generated posts, at their full size: kill points, live
#                           forums, peers, benchmarks
#   make dist           build wheels and sdists into dist/
#   make docs           the documentation site, in build/site
#   make check              format, lint, types, contracts, and the tests that run without a board, robot or agent
SHELL := /bin/sh
BIN := .venv/bin
ARGS ?=
# Tests wait for processes much of the time, so four workers keep two cores busy.
WORKERS ?= 4
# A simulated world must keep pace with the clock. Beside other tests it falls behind on a slow machine, so tests that need
# a world run two at a time, and beside them only those of PURE.
WORLDS ?= 2
# Give a worker whole files, so that a module's board, driver or world starts once, and the longest files first.
BY_FILE := --dist loadfile --no-loadscope-reorder
# At a low priority, because AgentRob gives one to some of its processes, such as those of previews: beside tests of normal
# priority they would wait for minutes.
PYTEST := nice -n 18 $(BIN)/pytest
# Packages whose tests run without a board, robot or agent.
QUICK := $(addprefix tests/,house language screening minds evals semantic process robots/control robots/safety)
# Folders with tests that mostly compute and have no short time limits. Tests with a world leave half of two cores idle; these
# use it, in the scheduling class SCHED_IDLE, which gets a core when nothing else wants it.
PURE := $(addprefix tests/,docs evals eyes language minds/extraction model packages rehearsal screening semantic sim/bodies)
PURE_PYTEST := chrt --idle 0 $(BIN)/pytest
# Files with tests that `make test` runs at a smaller size (tests/sizes.py).
SIZED = $(shell grep -rl --include='test_*.py' 'tests.sizes import' tests)
SLICE ?= 1/12
# There may be no tests of one kind; pytest then exits with 5.
OR_NONE := || [ $$? = 5 ]
# Tests start hundreds of Python processes; without compiled files each would compile all of its imports.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo dist docs test test-plugins test-slice test-long worlds pure check quick lint format lock setup setup-dev setup-slow clean

demo: setup
	@scripts/system-packages render
	@exec $(BIN)/agentrob demo $(ARGS)

docs: setup-dev
	@$(BIN)/python -m scripts.documentation

test: setup-dev
	@scripts/system-packages render browser
	@scripts/model-double
	@scripts/axe
	@scripts/viewer --check
	@echo "Running the tests with a simulated world and those that only compute; results follow in some minutes."
	@$(MAKE) --no-print-directory -j 2 --output-sync=target worlds pure
	$(PYTEST) -q -n $(WORKERS) $(BY_FILE) $(addprefix --ignore=,$(PURE)) -m "not sim and not slow" $(ARGS) $(OR_NONE)

worlds: setup-dev
	$(PYTEST) -q -n $(WORLDS) $(BY_FILE) --files-with sim -m "sim and not slow" $(ARGS) $(OR_NONE)

pure: setup-dev
	$(PURE_PYTEST) -q -n 2 $(BY_FILE) -m "not sim and not slow" $(PURE) $(ARGS) $(OR_NONE)

test-plugins: setup-dev
	$(PYTEST) -q plugins -m "not slow" $(ARGS)

test-slice: setup-slow
	@$(BIN)/python -m tests.slices $(SLICE)
	$(PYTEST) -q --slice $(SLICE) -m "slow and sim" $(ARGS) $(OR_NONE)
	$(PYTEST) -q -n 2 --dist worksteal --slice $(SLICE) -m "slow and not sim" $(ARGS) $(OR_NONE)

test-long: export AGENTROB_TEST_SIZE := full
test-long: setup-slow
	$(PYTEST) -q -n 2 --dist worksteal --files-with slow -m "slow and not sim" $(ARGS)
	$(PYTEST) -q --files-with slow -m "slow and sim" $(ARGS)
	$(PYTEST) -q -n 2 --dist worksteal -m "not slow and not sim" $(SIZED) $(ARGS)

setup-slow: setup-dev
	@scripts/system-packages render browser postgres peers reachy
	@scripts/model-double
	@scripts/axe
	@scripts/peers
	@scripts/mcp-peers
	@scripts/ros2-peers
	@scripts/reachy-mini-daemon

lint: setup-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# In parallel: without a cache, mypy alone takes a core for a minute.
check: setup-dev
	@scripts/model-double
	@$(MAKE) --no-print-directory -j 2 --output-sync=target lint quick

quick: setup-dev
	$(PYTEST) -q -n 2 --dist worksteal -m "not slow and not sim and not browser" $(QUICK) $(ARGS)

format: setup-dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

lock:
	@scripts/lock

dist: setup
	@scripts/dist

setup:
	@scripts/setup requirements.lock

setup-dev:
	@scripts/setup requirements-dev.lock

clean:
	rm -rf .venv build dist
