# AgentRob. Every target sets up what it needs in .venv by itself.
#   make demo               a forum, a simulated Go2 and its agent; prints the address to open
#   make demo ARGS='--post "@quadruped wave" --json'
#   make test               what every change must pass (under 15 minutes)
#   make test-all           that, and what is slow (under 45 minutes)
#   make check              format, lint, types, contracts, fast tests (one to two minutes)
SHELL := /bin/sh
BIN := .venv/bin
ARGS ?=
# Tests wait for robots half of the time: three at a time keep two cores busy. A simulated world has to keep pace.
MANY := -n 3
# Tests start Python by the hundred; without compiled files each would compile all that it imports.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-all test-slow check lint format lock setup setup-dev clean

demo: setup
	@scripts/system-packages render
	@exec $(BIN)/agentrob demo $(ARGS)

test: setup-dev
	@scripts/system-packages render browser
	@scripts/model-double
	@scripts/axe
	$(BIN)/pytest -q $(MANY) --dist worksteal -m "not slow and not sim and not browser" $(ARGS)
	$(BIN)/pytest -q $(MANY) --dist loadfile -m "not slow and browser and not sim" $(ARGS)
	$(BIN)/pytest -q -n 2 --dist loadfile -m "not slow and sim" $(ARGS)

test-slow: setup-dev
	@scripts/system-packages render browser postgres peers
	@scripts/model-double
	@scripts/axe
	@scripts/peers
	@scripts/mcp-peers
	$(BIN)/pytest -q -n 2 --dist worksteal -m "slow and not sim and not browser" $(ARGS)
	$(BIN)/pytest -q -n 2 --dist loadfile -m "slow and browser and not sim" $(ARGS)
	$(BIN)/pytest -m "slow and sim" $(ARGS)

test-all: test test-slow

lint: setup-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

check: lint
	@scripts/model-double
	$(BIN)/pytest -q $(MANY) -m "not slow and not sim and not browser" $(ARGS)

format: setup-dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

lock:
	@scripts/lock

setup:
	@scripts/setup requirements.lock

setup-dev:
	@scripts/setup requirements-dev.lock

clean:
	rm -rf .venv build dist
