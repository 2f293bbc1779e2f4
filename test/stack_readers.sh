#!/bin/sh
# SPDX-License-Identifier: MIT
# Other people's readers see what is in a stack: tifffile, GDAL and ImageJ each print one line a
# page, its label and a checksum of its samples, and so does a walker that knows only TIFF 6.0.
# All must agree. A reader that is not installed is skipped.
set -u
spectral=${SPECTRAL:-build/spectral}
python=${PYTHON:-/usr/bin/python3} # the one that sees the system's modules
imagej=${IMAGEJ_JAR:-/usr/share/java/ij.jar}
folder=${TEST_TMP:-build/tmp}/stack_readers
stack=$folder/patches.tif
count=0

truth() { # status, text: one line of TAP
    count=$((count + 1))
    if [ "$1" -eq 0 ]; then echo "ok $count - $2"; else echo "not ok $count - $2"; fi
}

skip() { # text, reason
    count=$((count + 1))
    echo "ok $count - $1 # SKIP $2"
}

same_lines() { # file with a reader's lines, text
    [ -s "$1" ] && cmp "$folder/expected" "$1" >/dev/null 2>&1
    status=$?
    truth "$status" "$2"
    [ "$status" -eq 0 ] || diff "$folder/expected" "$1" 2>&1 | head -10 | sed 's/^/# /'
}

# The checksum depends on every sample and its place: sum of (1 + index) x sample, modulo 2^31.
write_readers() {
    cat >"$folder/walker.py" <<'END'
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
    samples = array.array("H", data[first:first + size])
    checksum = sum((1 + i) * sample for i, sample in enumerate(samples)) % 2**31
    print(tags[285].rstrip(b"\0").decode(), checksum)
end = pixels[0][0]
for first, size in pixels:
    assert first == end, "pages follow each other"
    end = first + size
assert end == len(data), "the file ends with the last pixel"
assert directories_end <= pixels[0][0], "directories come first"
END
    cat >"$folder/with_tifffile.py" <<'END'
import sys, numpy, tifffile
import xml.etree.ElementTree as tree
OME = "{http://www.openmicroscopy.org/Schemas/OME/2016-06}"
with tifffile.TiffFile(sys.argv[1]) as stack:
    series = stack.series[0]
    assert len(stack.series) == 1 and series.axes == "CYX", series.axes
    assert series.shape == (len(stack.pages), 40, 60), series.shape
    channels = list(tree.fromstring(stack.ome_metadata).iter(OME + "Channel"))
    labels = [channel.get("Name") for channel in channels]
    centres = [float(channel.get("EmissionWavelength")) for channel in channels]
    assert numpy.allclose(centres, stack.pages[0].tags[65000].value, rtol=1e-7)
    assert labels == ["%.10g nm" % centre for centre in centres]
    assert stack.pages[0].tags[50839].value["Labels"] == labels
    assert stack.pages[0].tags[65111].value.strip()
    samples = series.asarray().reshape(len(labels), -1).astype(numpy.int64)
    for label, page in zip(labels, samples):
        print(label, int((numpy.arange(1, page.size + 1) * page).sum() % 2**31))
END
    cat >"$folder/with_gdal.py" <<'END'
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
    micrometres = float(band.GetMetadataItem("CENTRAL_WAVELENGTH_UM", "IMAGERY"))
    assert label == centre + " nm", label
    assert abs(micrometres * 1000 - float(centre)) < 1e-6, micrometres
    assert float(band.GetMetadataItem("FWHM_UM", "IMAGERY")) > 0
    assert band.GetMetadataItem("wavelength_units") == "Nanometers"
    assert abs(band.GetScale() - full_scale / 65535) <= 1e-12 * band.GetScale(), band.GetScale()
    assert band.GetOffset() == 0 and band.GetUnitType().startswith("W sr-1 m-2 nm-1")
    samples = band.ReadAsArray().astype(numpy.int64).ravel()
    print(label, int((numpy.arange(1, samples.size + 1) * samples).sum() % 2**31))
END
    cat >"$folder/WithImageJ.java" <<'END'
public class WithImageJ {
    public static void main(String[] arguments) {
        ij.ImageStack stack = new ij.io.Opener().openImage(arguments[0]).getStack();
        for (int slice = 1; slice <= stack.getSize(); slice++) {
            long checksum = 0;
            short[] samples = (short[]) stack.getPixels(slice);
            for (int i = 0; i < samples.length; i++)
                checksum += (1L + i) * (samples[i] & 0xffff);
            System.out.println(stack.getSliceLabel(slice) + " " + checksum % (1L << 31));
        }
    }
}
END
}

with_python() { # name of a reader, module that it needs
    text="$1 sees every page, its wavelength and its samples"
    if ! "$python" -c "import numpy; import $2" >/dev/null 2>&1; then
        skip "$text" "no Python module $2"
        return
    fi
    "$python" "$folder/with_$1.py" "$stack" >"$folder/$1.out" 2>"$folder/$1.err"
    truth "$?" "$1 finds the stack's metadata in order"
    sed 's/^/# /' "$folder/$1.err"
    same_lines "$folder/$1.out" "$text"
}

with_imagej() {
    text="ImageJ sees every slice, its label and its samples"
    if [ ! -e "$imagej" ] || ! java --list-modules 2>/dev/null | grep -q jdk.compiler; then
        skip "$text" "no ImageJ, or no Java that compiles"
        return
    fi
    java -Djava.awt.headless=true -cp "$imagej" "$folder/WithImageJ.java" "$stack" \
        >"$folder/imagej.out" 2>"$folder/imagej.err"
    sed 's/^/# /' "$folder/imagej.err"
    same_lines "$folder/imagej.out" "$text"
}

if ! "$python" -c 'import struct' >/dev/null 2>&1; then
    echo "1..0 # SKIP no Python"
    exit 0
fi
rm -rf "$folder"
mkdir -p "$folder"
write_readers
"$spectral" render patches --size 60x40 -o "$stack" >"$folder/render.out" 2>&1
truth "$?" "a stack is rendered"
sed 's/^/# /' "$folder/render.out"
if [ ! -e "$stack" ]; then
    echo "1..$count"
    exit 1
fi
"$python" "$folder/walker.py" "$stack" >"$folder/expected" 2>"$folder/walker.err"
truth "$?" "directories first, then pages without gaps up to the end of the file"
sed 's/^/# /' "$folder/walker.err"
[ "$(sort -u "$folder/expected" | wc -l)" -gt 1 ]
truth "$?" "the pages differ"
with_python tifffile tifffile
with_python gdal osgeo.gdal
with_imagej
echo "1..$count"
