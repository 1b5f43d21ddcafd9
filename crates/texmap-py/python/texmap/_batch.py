"""One verb over many items, in processes."""

import json
import os
import subprocess
import sys
from typing import Any, Dict, Iterable, List, Union

Path = Union[str, "os.PathLike[str]"]


def batch(items: Union[Path, Iterable[Path]], output: Path, verb: str = "render", **settings: Any) -> List[Dict[str, Any]]:
    """Runs a verb of the program over many items, on all cores, and returns a report of each unit, in their order.

    ``items`` are files, ``@list.txt`` or manifests; ``output`` is a folder or a name with ``{model}``, ``{dir}`` or ``{id}``. ``settings``
    are the flags of ``texmap batch`` and of the verb, with underscores for dashes: ``resolution="512x512", jobs=2, resume=True``;
    ``None`` and ``False`` leave a flag out. A report is a dictionary (``id``, ``status``, ``outputs``, ``pixel_hash``, ``error``, ...), as
    docs/batch.md lists it. One bad item does not stop the rest: look at ``status``.

    Raises ``ValueError`` with the program's words if the batch as a whole cannot be run.
    """
    several = [items] if isinstance(items, (str, os.PathLike)) else list(items)
    command = [sys.executable, "-m", "texmap", "--quiet", "batch", verb, *map(os.fspath, several), "-o", os.fspath(output), "--json"]
    for name, value in settings.items():
        if value is not None and value is not False:
            flag = "--" + name.replace("_", "-")
            command.append(flag if value is True else f"{flag}={value}")
    done = subprocess.run(command, capture_output=True, text=True)
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    units = [line for line in lines if "id" in line and "status" in line]
    if not units:
        raise ValueError(done.stderr.strip() or f"the batch ended with exit code {done.returncode}")
    return sorted(units, key=lambda unit: unit["index"])
