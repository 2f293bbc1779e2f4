#!/usr/bin/env -S PYTHONPATH=test/shared /usr/bin/python3 -B
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile imagej default-jdk-headless
"""ImageJ reads every page of a stack as tifffile does: its label and a checksum of its samples. tags.py reads the tags with tifffile;
recipes.py compares every sample, wavelength and scale that GDAL reads with those of tifffile. Prints TAP."""
import os
import subprocess

import numpy as np
import tifffile

from rendered import check, done, output_of, path_of, write

JAR = os.environ.get("IMAGEJ_JAR", "/usr/share/java/ij.jar")
# The checksum depends on every sample and its place: sum of (1 + index) x sample, modulo 2^31.
READER = write("WithImageJ.java", """public class WithImageJ {
    public static void main(String[] arguments) {
        ij.ImagePlus image = new ij.io.Opener().openImage(arguments[0]);
        if (!image.getInfoProperty().contains("full_scale: "))
            throw new RuntimeException("Image > Show Info lacks the full scale");
        ij.ImageStack stack = image.getStack();
        for (int slice = 1; slice <= stack.getSize(); slice++) {
            long checksum = 0;
            ij.process.ImageProcessor samples = stack.getProcessor(slice);
            for (int i = 0; i < samples.getPixelCount(); i++)
                checksum += (1L + i) * samples.get(i);
            System.out.println(stack.getSliceLabel(slice) + " " + checksum % (1L << 31));
        }
    }
}
""")

for options in ("--depth", "8"), ("--sampling", "rgb"), ("--sampling", "basis:4", "--depth", "8"), ():
    stack = path_of("colorchecker.tif")
    output_of("render", "colorchecker", "--size", "60x40", *options, "-o", stack, "--quiet")
    with tifffile.TiffFile(stack) as tiff:
        labels = tiff.pages[0].tags[50839].value["Labels"]
        pages = [page.asarray().ravel().astype(np.int64) for page in tiff.pages]
    expected = [f"{label} {(np.arange(1, page.size + 1) * page).sum() % 2**31}" for label, page in zip(labels, pages)]
    seen = subprocess.run(["java", "-Djava.awt.headless=true", "-cp", JAR, READER, stack], capture_output=True, text=True, check=False)
    check(seen.stdout.splitlines() == expected and len(pages) == len(labels) == len(set(expected)),
          f"ImageJ reads every page, its label and its samples {' '.join(options)}", seen.stdout, seen.stderr, expected)
done()
