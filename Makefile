# `make demo` and `make test` set up a fresh Debian or Ubuntu machine that has the Rust toolchain, nothing else.
.PHONY: demo live live-faults test check build setup

CARGO ?= cargo
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
# Without a desktop session Mesa complains about this variable at every start.
export XDG_RUNTIME_DIR ?= $(shell mktemp -d -t limpid-runtime-XXXXXX)

build:
	$(CARGO) build --release

# A Vulkan driver where no adapter is found: Mesa's software driver, which comes with the loader.
setup: build
	@target/release/limpid info >/dev/null 2>&1 || { \
		echo "no Vulkan adapter: installing mesa-vulkan-drivers"; \
		$(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq mesa-vulkan-drivers libvulkan1 >/dev/null; }
	@target/release/limpid info

demo: setup
	target/release/limpid demo -o demo

# A ROS 2 node on this machine: a recording is played into it, a picture and a table of latencies are left.
live: setup
	target/release/limpid demo --live -o live

# The tests run in release: software adapters are slow.
test: setup
	$(CARGO) test --release

# Faults of a node that take a minute each: a player that is paused, a subscriber that does not read, a network that is cut.
live-faults: setup
	LIMPID_LIVE_LONG=1 $(CARGO) test --release -- live::processes

# What a change must pass besides the tests.
check:
	$(CARGO) fmt --check
	$(CARGO) clippy --release --all-targets --features foxglove -- -D warnings
	$(CARGO) check --release --no-default-features --lib
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --release --no-deps
