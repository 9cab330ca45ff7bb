# Everything sets itself up: `make demo` and `make test` work on a bare machine with Python 3.11 or newer.
# Modules are compiled when they are first imported: most of what is installed never is.
PYTHON ?= python3
# Each Python has an environment of its own: `make demo PYTHON=python3.13 VENV=.venv-3.13`.
VENV ?= .venv
BIN := $(VENV)/bin
PIP := -m pip --quiet --disable-pip-version-check
# What is installed beside the service: `dev` to work on it, `smoke` for `make smoke` alone; `dev,docs` also what the
# site of its guide is built with.
EXTRAS ?= dev
# Where the demo leaves its reports, and how many processes run tests.
DEMO ?= out/demo
PROCESSES ?= 4
TRUEPOSE_DATA ?=
export TRUEPOSE_DATA

.PHONY: setup demo test thorough unit smoke attack installed check docs reference bench accuracy diagnosis-report ballbar-report hardening-report pages-report interruptions interface-report behaviour interface-accepted live-latency mutants nightly clean

setup: $(VENV)/.installed

$(VENV)/.installed: pyproject.toml service/build_hook.py $(wildcard service/packages/*)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || \
	  { echo "truepose needs Python 3.11 or newer, and $(PYTHON) is not: name one, as in make demo PYTHON=python3.13." >&2; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || \
	  { echo "$(PYTHON) makes no environments: install python3-venv (Debian, Ubuntu: apt-get install python3-venv)." >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python $(PIP) install --no-compile --editable '.[$(EXTRAS)]'
	touch $@ $(if $(findstring docs,$(EXTRAS)),$(VENV)/.docs)

demo: setup
	$(BIN)/truepose demo --out $(DEMO)

# A file of tests at a time, so that what a module sets up is set up once; long files first (`tests/conftest.py`), so
# that there is something to do beside them. Four processes on two cores: files of tests wait for half of their time,
# for a browser, a process, a cell; unit tests do not. One thread of linear algebra each: the matrices are small, and
# two threads wait for each other on busy cores. Compiled modules are kept, also where the environment says
# otherwise: a hundred commands are started, and each would compile the service anew. Files of tests lie in
# /dev/shm where that has room, as no test is about a computer that loses its power; TMPDIR says otherwise.
PYTEST := OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest \
  --dist loadfile --no-loadscope-reorder

test: setup
	$(PYTEST) --numprocesses $(PROCESSES) --ignore tests/thorough

# How often, how exactly and how well: causes at every size, studies, the demo and the wheel as they are installed.
thorough: setup
	$(PYTEST) --numprocesses $(PROCESSES) tests/thorough

unit: setup
	$(PYTEST) --numprocesses 2 tests/unit

# What every Python from 3.11 on is tried with beside the demo, also with the oldest versions of what is depended on
# (`tests/oldest.txt`): what meets the world, and a session of each kind.
SESSIONS := $(addprefix tests/, \
  system/sessions/test_session_on_simulated_cell.py system/sessions/test_ballbar_session.py \
  integration/web/measurement/test_camera_sessions.py integration/web/measurement/test_contact_sessions.py)

smoke: setup
	$(PYTEST) --numprocesses $(PROCESSES) -q tests/unit/drivers tests/unit/service/sessions tests/unit/service/exchange $(SESSIONS)

# What an attacker tried, in the order of its report: the wrist, unknown limits and inches; a bar nobody can read;
# models that were handed down; the speed of the tool; guesses, tokens, secrets; broken text, files and requests.
ATTACK := $(addprefix tests/, \
  unit/service/exchange/programs/test_controllers.py unit/service/cli/test_correct_command.py \
  unit/service/exchange/robots/test_known_limits.py thorough/system/studies/test_lost_signals.py \
  unit/service/sessions/ballbar/lengths/test_signals_outrank_words.py \
  integration/web/measurement/acts/test_bar_left_attached.py unit/service/cli/test_model_acceptance.py \
  integration/web/replication/test_hand_downs.py integration/exchange/test_cell_file.py \
  integration/web/people/test_guessing.py unit/service/people/test_attempts.py \
  integration/web/people/test_programs.py integration/web/people/test_pins_of_others.py \
  integration/storage/secrecy unit/service/web/test_half_characters.py integration/web/test_any_requests.py \
  unit/service/exchange/test_campaign_zip.py unit/service/exchange/tables/test_texts.py \
  integration/deployment/test_compose_file.py)

attack: setup
	$(PYTEST) --numprocesses 2 $(ATTACK)

# As somebody has it who never saw the checkout: the wheel in an environment of its own, the demo in an empty folder.
installed: setup
	rm -rf out/installed && mkdir -p out/installed/empty
	$(BIN)/python $(PIP) wheel --no-deps --wheel-dir out/installed .
	$(PYTHON) -m venv out/installed/venv
	out/installed/venv/bin/python $(PIP) install --no-compile out/installed/truepose-*.whl
	cd out/installed/empty && env -u PYTHONPATH ../venv/bin/truepose demo

check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/.docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --config-file docs/site/mkdocs.yml

# The pages of docs/reference, from the code; a test holds them to it.
reference: setup
	$(BIN)/python -m tests.helpers.reference_pages

$(VENV)/.docs: $(VENV)/.installed
	$(BIN)/python $(PIP) install --no-compile --editable '.[docs]'
	touch $@

# Speed, peers beside it in environments of their own; on one core, like the figures of docs/figures/speed.csv.
bench: setup
	OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m tests.studies.bench --out out/bench

accuracy: setup
	$(BIN)/python -m tests.studies.accuracy --out out/accuracy

diagnosis-report: setup
	$(BIN)/python -m tests.studies.diagnosis_report --out out/diagnosis

ballbar-report: setup
	$(BIN)/python -m tests.studies.ballbar_report --out out/ballbar

# Two hours on two idle cores; each study has a command of its own, in docs/figures/README.md.
hardening-report: setup
	$(BIN)/python -m tests.studies.hardening.erring_operator --out out/hardening
	$(BIN)/python -m tests.studies.hardening.wrong_pairs --out out/hardening
	$(BIN)/python -m tests.studies.hardening.hostile_wires --bytes 2000000 --out out/hardening
	$(BIN)/python -m tests.studies.hardening.crowded_door --out out/hardening
	$(BIN)/python -m tests.studies.hardening.giant_upload --out out/hardening
	$(BIN)/python -m tests.studies.hardening.storage_refusals --lock-s 60 --out out/hardening
	$(BIN)/python -m tests.studies.hardening.tampering --out out/hardening
	$(BIN)/python -m tests.studies.hardening.durable_writes --out out/hardening
	$(BIN)/python -m tests.studies.hardening.ready_again --readings 1000000 --out out/hardening
	$(BIN)/python -m tests.studies.hardening.session_overhead --out out/hardening
	$(BIN)/python -m tests.studies.hardening.cuts --out out/hardening

pages-report: setup
	$(BIN)/python -m tests.studies.pages --out out/pages

# Two hundred kills of a ballbar session take a quarter of an hour; the latency of the live stream half a minute.
interruptions: setup
	$(BIN)/python -m tests.studies.interruptions --kills 200 --out out/interruptions

# Twice fifty examples of each of ninety operations and each phase: an hour and a half on two idle cores.
interface-report: setup
	$(BIN)/python -m tests.studies.every_request --out out/interface

# What commands, replies, pages and wires say today; tests hold every later change against it.
behaviour: setup
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.recorded

# What programs may rely on, as it is today; a test holds every later change against it.
interface-accepted: setup
	$(BIN)/python -m tests.studies.accepted_interface

live-latency: setup
	$(BIN)/python -m tests.studies.interruptions.live_latency

# Four hundred errors that somebody could make, each before the unit tests of its room: some hours.
mutants: setup
	$(BIN)/python -m tests.studies.mutants --out out/mutants

# A night is found again by its commit.
nightly: setup
	PYTHONPATH=. $(BIN)/truepose nightly --out out/nightly --bench tests.contract.devices.every:BENCHES --label "$$(git rev-parse --short HEAD 2>/dev/null)"

clean:
	rm -rf $(VENV) .venv-* out build dist
