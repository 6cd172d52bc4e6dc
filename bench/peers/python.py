"""Detectors that are reached from Python, measured for tagbus-bench: OpenCV's ArUco module and AprilTag 2.

Needs an interpreter with these packages, for example:

    python3 -m venv target/python
    target/python/bin/pip install setuptools wheel 'cmake<4' opencv-contrib-python-headless==5.0.0.93
    PATH=$PWD/target/python/bin:$PATH CMAKE_POLICY_VERSION_MINIMUM=3.5 \
        target/python/bin/pip install --no-build-isolation apriltag==0.0.16
    cargo run --release -p tagbus-bench --features peers -- sweep textured --python target/python/bin/python

What is not installed is left out. The bench starts this program once for a family and talks to it in lines of JSON:

    (start)                                         -> [{"name": .., "factor": .., "variant": ..}, ..]
    {"raw": path, "width": w, "height": h}          -> {}
    {"detect": number of the configuration}         -> {"cpu_us": .., "hits": [{"id": .., "corners": [[x, y] * 4]}, ..]}

Only the call of the detector is timed, in CPU time of this process, on one thread. Corners are handed over with
(0, 0) at the top-left corner of the top-left pixel.
"""

import json
import sys
import time

import numpy


def opencv_configurations(family):
    """OpenCV's own pipeline, plain and with corners refined, and ArUco3 with its smallest marker size swept."""
    try:
        import cv2
    except ImportError:
        return
    if family != "tag36h11":
        return
    cv2.setNumThreads(1)
    name = "OpenCV " + cv2.__version__ + " ArUco"
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)

    def configuration(variant, **settings):
        parameters = cv2.aruco.DetectorParameters()
        for key, value in settings.items():
            setattr(parameters, key, value)
        detector = cv2.aruco.ArucoDetector(dictionary, parameters)

        def hits(picture):
            corners, ids, _ = detector.detectMarkers(picture)
            return corners, ids

        def listed(found):
            corners, ids = found
            pairs = zip(corners, [] if ids is None else ids.flatten())
            # OpenCV counts from the middle of the first pixel.
            return [{"id": int(id_), "corners": (quad.reshape(4, 2) + 0.5).tolist()} for quad, id_ in pairs]

        return {"name": name, "factor": 1.0, "variant": variant}, hits, listed

    subpix = cv2.aruco.CORNER_REFINE_SUBPIX
    yield configuration("plain")
    yield configuration("subpix", cornerRefinementMethod=subpix)
    for smallest in (0.0, 0.01, 0.02, 0.04, 0.06, 0.08, 0.11):
        yield configuration(
            f"ArUco3 from {smallest}",
            cornerRefinementMethod=subpix,
            useAruco3Detection=True,
            minMarkerLengthRatioOriginalImg=smallest,
        )


def april_tag_2_configurations(family):
    """AprilTag 2 as published: quads from clusters of gradients, not from contours."""
    try:
        import apriltag
    except ImportError:
        return
    if family != "tag36h11":
        return

    def configuration(factor):
        options = apriltag.DetectorOptions(
            families="tag36h11", nthreads=1, quad_decimate=factor, quad_contours=False
        )
        detector = apriltag.Detector(options)

        def listed(found):
            return [{"id": int(tag.tag_id), "corners": tag.corners.tolist()} for tag in found]

        return {"name": "AprilTag 2", "factor": factor, "variant": ""}, detector.detect, listed

    # Other factors write beyond the ends of their buffers when a side of the picture is not a multiple of them.
    for factor in (1.0, 2.0, 3.0, 4.0):
        yield configuration(factor)


def answer(message):
    print(json.dumps(message), flush=True)


def main():
    family = sys.argv[1]
    configurations = [*opencv_configurations(family), *april_tag_2_configurations(family)]
    answer([described for described, _, _ in configurations])
    picture = None
    for line in sys.stdin:
        request = json.loads(line)
        if "raw" in request:
            shape = (request["height"], request["width"])
            picture = numpy.fromfile(request["raw"], dtype=numpy.uint8).reshape(shape)
            answer({})
        else:
            _, detect, listed = configurations[request["detect"]]
            time.process_time_ns()  # Brings near what the kernel needs for it, which would be counted otherwise.
            before = time.process_time_ns()
            found = detect(picture)
            cpu_us = (time.process_time_ns() - before) * 1e-3
            answer({"cpu_us": cpu_us, "hits": listed(found)})


if __name__ == "__main__":
    main()
