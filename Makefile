# For a fresh machine with Python 3.11 or newer: `make demo`, `make test`, and `make quick`
# (under 90 s: the style, the direction of imports, and the rooms that only calculate).
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin
OUT := demo-output
DB := $(OUT)/motions.duckdb
QUICK := tests/test_house.py tests/body tests/symbols tests/language tests/generate \
  tests/fetch tests/pictures  # no database, no processes
PAGE := $(BIN)/python build_backend.py  # pip hides whether the page was built: say it before a run

.PHONY: demo test quick test-browser lint clean

demo: $(BIN)/.installed
	rm -rf $(OUT) && mkdir -p $(OUT)
	$(BIN)/motiondb add sample_data/captures --words sample_data/captions.tsv --db $(DB)
	$(BIN)/motiondb learn --db $(DB)
	$(BIN)/motiondb search "walk, turn left, sit down" --limit 5 --png $(OUT)/search.png --db $(DB)
	$(BIN)/motiondb like sample_data/captures/fatou/kick_1.bvh --from 0.5 --to 2.0 --limit 5 --db $(DB)
	$(BIN)/motiondb describe ana/long_1 --db $(DB)
	$(BIN)/motiondb generate "a person walks then kicks" -o $(OUT)/walk_kick.bvh --seed 7 --png $(OUT)/walk_kick.png --db $(DB)
	$(BIN)/motiondb add sample_data/captures --db $(OUT)/without-words.duckdb
	$(BIN)/motiondb learn --start cmu --db $(OUT)/without-words.duckdb
	$(BIN)/motiondb search "sit down" --limit 5 --db $(OUT)/without-words.duckdb
	@echo "Look at $(OUT)/search.png and $(OUT)/walk_kick.png; open $(OUT)/walk_kick.bvh in Blender."

test: $(BIN)/.tested
	-@$(PAGE)
	$(BIN)/python -m pytest -n 2 -q -rs --dist loadfile --no-loadscope-reorder --ignore tests/page_browser

quick: $(BIN)/.tested
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	$(BIN)/python -m pytest -n 2 -q -m "not slow" $(QUICK)

test-browser: $(BIN)/.tested  # clicks, drags and uploads in Chromium; says what is skipped where there is none
	$(BIN)/python -m pytest -n 2 -q -rs --dist loadfile tests/page_browser \
	  || { echo "Once more, alone: what failed beside others on a busy machine."; \
	       $(BIN)/python -m pytest -q --last-failed --last-failed-no-failures none tests/page_browser; }

lint: $(BIN)/.tested
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy
	$(BIN)/python -m pytest -q tests/test_house.py -k imports  # import-linter, with cli/ where it is installed

# Without the page, which no command of the demo shows; modules are compiled when they are imported
$(BIN)/.installed: pyproject.toml
	$(PYTHON) -m venv .venv
	MOTIONDB_PAGE=0 $(BIN)/python -m pip install --quiet --no-compile --editable .
	touch $@

$(BIN)/.tested: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	touch $@ $(BIN)/.installed

clean:
	rm -rf .venv $(OUT) build *.egg-info motiondb/page/bundle motiondb/page/web/node_modules
