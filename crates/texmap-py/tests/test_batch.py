"""Batches from Python."""

import pytest

import texmap


def test_reports_are_in_order_and_pictures_those_of_single_calls(assets, tmp_path):
    models = [assets / "models" / name for name in ["head.obj", "cube.obj", "cone.obj"]]
    units = texmap.batch(models, tmp_path / "{model}.png", resolution="64x48", jobs=2)
    assert [unit["status"] for unit in units] == ["ok"] * 3
    drawn = [texmap.render(str(model), size=(64, 48)).hash for model in models]
    assert [unit["pixel_hash"] for unit in units] == drawn
    assert all((tmp_path / name).stat().st_size > 0 for name in ["cube.png", "head.png", "cone.png"])
    again = texmap.batch(models, tmp_path / "{model}.png", resolution="64x48", resume=True)
    assert all(unit["resumed"] for unit in again)
    (tmp_path / "list.txt").write_text("\n".join(map(str, models)))
    listed = texmap.batch([f"@{tmp_path / 'list.txt'}"], tmp_path / "{model}.png", resolution="64x48", resume=True)
    assert [unit["index"] for unit in listed] == [0, 1, 2]


def test_one_bad_item_is_told_and_the_rest_is_drawn(assets, tmp_path):
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 zero 0\n")
    units = texmap.batch([assets / "models" / "cube.obj", bad], tmp_path / "out", resolution="32x24")
    assert sorted(unit["status"] for unit in units) == ["failed", "ok"]
    with pytest.raises(ValueError, match="resolution"):
        texmap.batch([bad], tmp_path / "out", resolution="wide")
