# SPDX-License-Identifier: MIT
# Draws a picture in parts by Make, several at a time, and joins them:
#   make -f parts.mk -j 4 STACK=large.tif SCENE=patches OPTIONS='--size 1600x1600' PARTS=8
# If it is stopped, the same command goes on. Names have no blanks. To draw a scene that has changed: make -f parts.mk clean ...
SPECTRAL ?= spectral
PARTS ?= 4
SCENE ?= colorchecker
STACK ?= $(SCENE).tif
OPTIONS ?=
drawn := $(patsubst %,$(STACK).%-of-$(PARTS).drawn,$(shell seq $(PARTS)))

$(STACK): $(drawn)
	$(SPECTRAL) join $@

# A part's file is there before it is complete, so that a file of its own says so.
$(STACK).%-of-$(PARTS).drawn: $(wildcard $(SCENE))
	$(SPECTRAL) render $(SCENE) $(OPTIONS) -o $(STACK) --part $*/$(PARTS) --threads 1 --quiet
	touch $@

clean:
	rm -f $(drawn) $(drawn:.drawn=.part)
.PHONY: clean
