#!/bin/sh
# SPDX-License-Identifier: MIT
# level: release; packages: python3-numpy python3-tifffile python3-gdal imagej default-jdk-headless
# Readers of other programs read stacks correctly: tifffile, GDAL and ImageJ each print one line a page, its label
# and a checksum of its samples, and so does a small walker that knows only TIFF 6.0. All must agree. A reader that
# is not installed is skipped.
. test/shared/tap.sh
python=${PYTHON:-/usr/bin/python3} # the Python that finds the system's modules
imagej=${IMAGEJ_JAR:-/usr/share/java/ij.jar}
stack=$tmp/colorchecker.tif

sees() { # READER COMMAND...: the command succeeds and prints the same lines as the walker
    reader=$1
    shift
    exits 0 "$reader finds the stack in order" "$@"
    cp "$tmp/out" "$tmp/seen"
    exits 0 "$reader reads every page, its wavelength and its samples" \
        diff "$tmp/expected" "$tmp/seen"
}

all_see() {
    exits 0 "directories first, then pages without gaps up to the end of the file" \
        "$python" "$tmp/walker.py" "$stack"
    cp "$tmp/out" "$tmp/expected"
    [ "$(sort -u "$tmp/expected" | wc -l)" -gt 1 ]
    ok $? "the pages differ"
    for pair in tifffile:tifffile gdal:osgeo.gdal; do
        if "$python" -c "import numpy; import ${pair#*:}" >/dev/null 2>&1; then
            sees "${pair%:*}" "$python" "$tmp/with_${pair%:*}.py" "$stack"
        else
            skip "no Python module ${pair#*:}, or no numpy"
        fi
    done
    if [ -e "$imagej" ] && java --list-modules 2>/dev/null | grep -q jdk.compiler; then
        sees ImageJ java -Djava.awt.headless=true -cp "$imagej" "$tmp/WithImageJ.java" "$stack"
    else
        skip "no ImageJ, or no Java that compiles"
    fi
}

# The checksum depends on every sample and its place: sum of (1 + index) x sample, modulo 2^31.
write_readers() {
    cat >"$tmp/walker.py" <<'END'
import array, struct, sys
data = open(sys.argv[1], "rb").read()
magic, at = struct.unpack_from("<2xHI", data)
assert data[:2] == b"II" and magic == 42
directories_end, pixels = 0, []
while at:
    entries = struct.unpack_from("<H", data, at)[0]
    tags = {}
    for entry in range(at + 2, at + 2 + 12 * entries, 12):
        tag, kind, count, value = struct.unpack_from("<HHII", data, entry)
        size = count * (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8)[kind]
        place = value if size > 4 else entry + 8
        tags[tag] = data[place:place + size]
        directories_end = max(directories_end, place + size)
    directories_end = max(directories_end, at + 6 + 12 * entries)
    at = struct.unpack_from("<I", data, at + 2 + 12 * entries)[0]
    pixels.append([struct.unpack("<I", tags[tag])[0] for tag in (273, 279)])
    first, size = pixels[-1]
    samples = array.array("B" if tags[258][0] == 8 else "H", data[first:first + size])
    checksum = sum((1 + i) * sample for i, sample in enumerate(samples)) % 2**31
    print(tags[285].rstrip(b"\0").decode(), checksum)
end = pixels[0][0]
for first, size in pixels:
    assert first == end, "pages follow each other"
    end = first + size
assert end + 60 * 40 == len(data), "the file ends with the object map"
assert directories_end <= pixels[0][0], "directories come first"
END
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
    cat >"$tmp/with_gdal.py" <<'END'
import re, sys, numpy
from osgeo import gdal
gdal.UseExceptions()
whole = gdal.Open(sys.argv[1])
text = whole.GetMetadataItem("TIFFTAG_IMAGEDESCRIPTION")
full_scale = float(re.search("full_scale: (\\S+)", text).group(1))
for name, _ in whole.GetSubDatasets():
    page = gdal.Open(name)
    band = page.GetRasterBand(1)
    label, centre = band.GetDescription(), band.GetMetadataItem("wavelength")
    if centre is None:
        assert not band.GetMetadata("IMAGERY") and not band.GetUnitType(), band.GetUnitType()
    else:
        micrometres = float(band.GetMetadataItem("CENTRAL_WAVELENGTH_UM", "IMAGERY"))
        assert label == centre + " nm", label
        assert abs(micrometres * 1000 - float(centre)) < 1e-6, micrometres
        assert float(band.GetMetadataItem("FWHM_UM", "IMAGERY")) > 0
        assert band.GetMetadataItem("wavelength_units") == "Nanometers"
        assert band.GetUnitType().startswith("W sr-1 m-2 nm-1")
    largest = 255 if band.DataType == gdal.GDT_Byte else 65535
    assert abs(band.GetScale() - full_scale / largest) <= 1e-12 * band.GetScale(), band.GetScale()
    assert band.GetOffset() == 0
    samples = band.ReadAsArray().astype(numpy.int64).ravel()
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

"$python" -c 'import struct' >/dev/null 2>&1 || skip_all "no Python"
write_readers
for options in '--depth 8' '--sampling rgb' '--sampling basis:4 --depth 8' ''; do
    # shellcheck disable=SC2086 # options are words
    exits 0 "a stack is rendered ${options:-without options}" \
        "$SPECTRAL" render colorchecker --size 60x40 $options -o "$stack" --quiet
    all_see
done
done_testing
