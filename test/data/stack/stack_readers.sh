#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile imagej default-jdk-headless
# ImageJ reads every page of a stack as tifffile does: its label and a checksum of its samples. It is skipped if it is not installed.
# tags.py reads the tags with tifffile; recipes.py compares every sample, wavelength and scale that GDAL reads with those of tifffile.
. test/shared/tap.sh
python=${PYTHON:-/usr/bin/python3} # the Python that finds the system's modules
imagej=${IMAGEJ_JAR:-/usr/share/java/ij.jar}
stack=$tmp/colorchecker.tif

all_see() {
    exits 0 "tifffile finds the stack in order" "$python" "$tmp/with_tifffile.py" "$stack"
    cp "$tmp/out" "$tmp/expected"
    [ "$(sort -u "$tmp/expected" | wc -l)" -gt 1 ]
    ok $? "the pages differ"
    if [ -e "$imagej" ] && java --list-modules 2>/dev/null | grep -q jdk.compiler; then
        exits 0 "ImageJ finds the stack in order" java -Djava.awt.headless=true -cp "$imagej" "$tmp/WithImageJ.java" "$stack"
        cp "$tmp/out" "$tmp/seen"
        exits 0 "ImageJ reads every page, its wavelength and its samples" diff "$tmp/expected" "$tmp/seen"
    else
        skip "no ImageJ, or no Java that compiles"
    fi
}

# The checksum depends on every sample and its place: sum of (1 + index) x sample, modulo 2^31.
write_readers() {
    cat >"$tmp/with_tifffile.py" <<'END'
import sys, numpy, tifffile
with tifffile.TiffFile(sys.argv[1]) as stack:
    for label, page in zip(stack.pages[0].tags[50839].value["Labels"], stack.pages):
        samples = page.asarray().ravel().astype(numpy.int64)
        print(label, int((numpy.arange(1, samples.size + 1) * samples).sum() % 2**31))
END
    cat >"$tmp/WithImageJ.java" <<'END'
public class WithImageJ {
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
END
}

"$python" -c 'import numpy, tifffile' >/dev/null 2>&1 || skip_all "no tifffile"
write_readers
for options in '--depth 8' '--sampling rgb' '--sampling basis:4 --depth 8' ''; do
    # shellcheck disable=SC2086 # options are words
    exits 0 "a stack is rendered ${options:-without options}" \
        "$SPECTRAL" render colorchecker --size 60x40 $options -o "$stack" --quiet
    all_see
done
done_testing
