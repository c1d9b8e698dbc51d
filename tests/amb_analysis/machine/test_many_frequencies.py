"""Computed responses at many frequencies, as records of an hour have them."""

import tracemalloc

import numpy as np

from amb_analysis.machine.channels import place_of
from amb_analysis.machine.frequency_response import BLOCK, Structure, frequency_response
from rotor_analysis.rotor_file import load_rotor

BYTES = 200  # of a frequency: the response, its frequency and intermediate copies


def test_responses_at_many_frequencies_take_memory_for_the_data_alone():
    """Displacements of all nodes at all frequencies were in memory, 23 kB for each frequency."""
    rotor = load_rotor("compressor")
    places = [place_of("impeller3.x", "N", rotor, is_input=True), place_of("seal.x", "m", rotor, is_input=False)]
    structure = Structure(rotor, "free")
    peaks = []
    for count in (2 * BLOCK, 6 * BLOCK):
        tracemalloc.start()
        H = frequency_response(structure, places[:1], places[1:], np.linspace(10.0, 500.0, count))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] - peaks[0] < BYTES * 4 * BLOCK
    single = frequency_response(
        structure, places[:1], places[1:], np.linspace(10.0, 500.0, 6 * BLOCK)[BLOCK : BLOCK + 1], 500.0
    )
    np.testing.assert_allclose(H[BLOCK : BLOCK + 1], single, rtol=1e-12)
