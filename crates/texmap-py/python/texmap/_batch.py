"""One verb over many items, in processes."""

import json
import os
import subprocess
import sys
from typing import Any, Dict, Iterable, List, Union

Path = Union[str, "os.PathLike[str]"]


def batch(items: Union[Path, Iterable[Path]], output: Path, verb: str = "render", **settings: Any) -> List[Dict[str, Any]]:
    """Runs a verb of the program over many items, on all cores, and returns a report of each unit: in the order of ``items``, those of
    lists and manifests last, in that of their ids.

    ``items`` are files, ``@list.txt`` or manifests; ``output`` is a folder or a name with ``{model}``, ``{dir}`` or ``{id}``. ``settings``
    are the flags of ``texmap batch`` and of the verb, with underscores for dashes: ``resolution="512x512", jobs=2, resume=True``;
    ``None`` and ``False`` leave a flag out. A report is a dictionary (``id``, ``status``, ``outputs``, ``pixel_hash``, ``error``, ...), as
    docs/batch.md lists it. One bad item does not stop the rest: look at ``status``.

    Raises ``ValueError`` with the program's words if the batch as a whole cannot be run.
    """
    several = [items] if isinstance(items, (str, os.PathLike)) else list(items)
    where = os.fspath(output)
    if "{" not in where and not os.path.splitext(where)[1]:
        where = os.path.join(where, "")
    command = [sys.executable, "-m", "texmap", "--quiet", "batch", verb, *map(os.fspath, several), "-o", where, "--json"]
    for name, value in settings.items():
        if value is not None and value is not False:
            flag = "--" + name.replace("_", "-")
            command.append(flag if value is True else f"{flag}={value}")
    done = subprocess.run(command, capture_output=True, text=True)
    # A line for each unit and a summary; the report of a batch that cannot be run has several lines.
    lines = [line for line in done.stdout.splitlines() if line.startswith('{"')]
    units = [unit for unit in map(json.loads, lines) if "id" in unit and "status" in unit]
    if not units:
        raise ValueError(done.stderr.strip() or f"the batch ended with exit code {done.returncode}")
    # The program counts units in the order of their ids.
    order = {os.fspath(item): k for k, item in enumerate(several)}
    return sorted(units, key=lambda unit: (order.get(unit["input"], len(order)), unit["index"]))
