"""The table of the latency page is what its tool makes from the stored results."""

from __future__ import annotations

import copy
import json

import pytest

from tools import measure_latency


def test_the_page_has_the_table_of_the_stored_results():
    text = measure_latency.PAGE.read_text(encoding="utf-8")
    results = json.loads(measure_latency.RESULTS.read_text(encoding="utf-8"))
    assert measure_latency.renewed(text, results) == text
    assert results["machine"] in text
    other = copy.deepcopy(results)
    other["waits_ms"]["OSC"]["256"]["p99"] += 1.0
    assert measure_latency.renewed(text, other) != text


@pytest.mark.parametrize("source", measure_latency.SOURCES)
def test_a_measurement_has_a_wait_for_each_source(source):
    found = measure_latency.measure(source, 256, 5)
    assert 0.0 <= found["median"] <= found["p99"] <= found["worst"]
