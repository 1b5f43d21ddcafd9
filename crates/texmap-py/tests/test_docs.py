"""The blocks of docs/python.md and of the README, run as they stand; TEXMAP_BLESS=1 writes their pictures to docs/images/python."""

import os
import re
import runpy
import shutil

import pytest
from conftest import ROOT

DOCS = ROOT / "docs"


def blocks():
    text = (DOCS / "python.md").read_text()
    found = [("install", re.search(r"```python\n(.*?)```", text, re.S).group(1))]
    for title, body in re.findall(r"^##+ ([^\n]+)\n(.*?)(?=^##|\Z)", text, re.S | re.M):
        code = re.search(r"```python\n(.*?)```", body, re.S)
        if code:
            found.append((title, code.group(1)))
    readme = (ROOT / "README.md").read_text()
    found.append(("README", re.search(r"## Python\n.*?```python\n(.*?)```", readme, re.S).group(1)))
    return found


BLOCKS = blocks()


@pytest.mark.parametrize("title,code", BLOCKS, ids=[title for title, _ in BLOCKS])
def test_block(title, code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "assets").symlink_to(ROOT / "assets")
    (tmp_path / "block.py").write_text(code)
    runpy.run_path("block.py")
    pictures = sorted(tmp_path.glob("*.png"))
    assert pictures and all(p.stat().st_size > 1000 for p in pictures)
    if os.environ.get("TEXMAP_BLESS"):
        folder = DOCS / "images" / "python"
        folder.mkdir(exist_ok=True)
        for picture in pictures:
            if f"images/python/{picture.name}" in (DOCS / "python.md").read_text():
                shutil.copy(picture, folder / picture.name)


def test_there_are_six_short_tasks():
    tasks = (DOCS / "python.md").read_text().split("## Six tasks")[1].split("\n## ")[0]
    codes = re.findall(r"```python\n(.*?)```", tasks, re.S)
    assert len(codes) == 6 and all(len(code.strip().splitlines()) <= 10 for code in codes)
    for name in re.findall(r"\(images/(python/[^)]+)\)", (DOCS / "python.md").read_text()):
        assert (DOCS / "images" / name).is_file(), name


def test_readme_has_three_lines():
    code = dict(BLOCKS)["README"]
    assert len(code.strip().splitlines()) == 3
