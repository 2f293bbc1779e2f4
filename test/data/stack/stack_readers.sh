#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile imagej default-jdk-headless
# Readers of other programs read stacks correctly: tifffile and ImageJ each print one line a page, its label and a checksum of
# its samples. Both must agree. ImageJ is skipped if it is not installed. test_stack.c finds each sample
# where libtiff says; recipes.py compares every sample, wavelength and scale that GDAL reads with those of tifffile.
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
import xml.etree.ElementTree as tree
OME = "{http://www.openmicroscopy.org/Schemas/OME/2016-06}"
with tifffile.TiffFile(sys.argv[1]) as stack:
    series = stack.series[0]
    assert len(stack.series) == 1 and series.axes == "CYX", series.axes
    assert series.shape == (len(stack.pages), 40, 60), series.shape
    channels = list(tree.fromstring(stack.ome_metadata).iter(OME + "Channel"))
    labels = [channel.get("Name") for channel in channels]
    if channels[0].get("EmissionWavelength") is None:
        assert 65000 not in stack.pages[0].tags and not any("nm" in label for label in labels)
    else:
        centres = [float(channel.get("EmissionWavelength")) for channel in channels]
        assert numpy.allclose(centres, stack.pages[0].tags[65000].value, rtol=1e-7)
        assert labels == ["%.10g nm" % centre for centre in centres]
    assert stack.pages[0].tags[50839].value["Labels"] == labels
    assert stack.pages[0].tags[65111].value.strip()
    samples = series.asarray().reshape(len(labels), -1).astype(numpy.int64)
    for label, page in zip(labels, samples):
        print(label, int((numpy.arange(1, page.size + 1) * page).sum() % 2**31))
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
