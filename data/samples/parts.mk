# SPDX-License-Identifier: MIT
# Draws a picture in parts by Make, several at a time, joins them, and removes them:
#   make -f parts.mk -j 4 STACK=large.tif SCENE=patches OPTIONS='--size 1600x1600' PARTS=4
# If it is stopped, the same command goes on with the parts that are missing. Names have no blanks.
SPECTRAL ?= spectral
PARTS ?= 2
SCENE ?= colorchecker
STACK ?= $(SCENE).tif
OPTIONS ?=
parts := $(patsubst %,$(STACK).%-of-$(PARTS).tif,$(shell seq $(PARTS)))

$(STACK): $(parts)
	$(SPECTRAL) join -o $@ $^
	rm $^

$(STACK).%-of-$(PARTS).tif: $(wildcard $(SCENE))
	$(SPECTRAL) render $(SCENE) $(OPTIONS) --part $*/$(PARTS) -o $@ --threads 1 --quiet

.SECONDARY: $(parts)
