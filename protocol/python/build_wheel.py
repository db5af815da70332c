# SPDX-License-Identifier: BSD-3-Clause
"""Build backend of our packages (PEP 517, PEP 660): `pip install protocol/python`, or of the folder of all, needs no
network, and leaves no files behind there.

pip calls these functions in the folder of pyproject.toml. The package has the name of the project there. With
`checkout = "FILE"` in the table tool.build_wheel its programs stay in that folder: FILE in the package names it.
"""

import base64
import contextlib
import hashlib
import io
import re
import tarfile
import tomllib
import zipfile
from pathlib import Path

TAG = "py3-none-any"
OLDEST = (1980, 1, 1, 0, 0, 0)  # the same files give the same wheel

with contextlib.suppress(OSError, TypeError):  # files that the import of this one has written beside it
    Path(__cached__).unlink()
    Path(__cached__).parent.rmdir()


def settings() -> dict:
    return tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))


def project() -> dict:
    """The table project; a version that is dynamic there is that of CMakeLists.txt."""
    about = settings()["project"]
    if "version" in about.get("dynamic", []):
        text = Path("CMakeLists.txt").read_text(encoding="utf-8")
        about["version"] = re.search(r"^project\(\w+ VERSION (\S+)", text, re.MULTILINE)[1]
    return about


def package() -> str:
    return project()["name"].replace("-", "_")


def note() -> str | None:
    """File of the package that names the folder it comes from."""
    return settings().get("tool", {}).get("build_wheel", {}).get("checkout")


def metadata() -> str:
    about = project()
    lines = ["Metadata-Version: 2.1", f"Name: {about['name']}", f"Version: {about['version']}",
             f"Summary: {about['description']}", f"License: {about['license']['text']}",
             f"Requires-Python: {about['requires-python']}",
             *(f"Requires-Dist: {needed}" for needed in about["dependencies"])]
    return "\n".join([*lines, ""])


def sources() -> list[Path]:
    return sorted(Path(package()).rglob("*.py"))


def write_wheel(folder: str, files: dict[str, bytes]) -> str:
    """Name of the wheel with these files, metadata and the list of all (RECORD)."""
    about = f"{package()}-{project()['version']}.dist-info"
    files |= {f"{about}/METADATA": metadata().encode(),
              f"{about}/WHEEL": (f"Wheel-Version: 1.0\nGenerator: {package()}\n"
                                 f"Root-Is-Purelib: true\nTag: {TAG}\n").encode()}
    rows = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        rows.append(f"{name},sha256={digest},{len(content)}")
    files[f"{about}/RECORD"] = "\n".join([*rows, f"{about}/RECORD,,", ""]).encode()
    wheel = f"{package()}-{project()['version']}-{TAG}.whl"
    with zipfile.ZipFile(Path(folder) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, OLDEST)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return wheel


def build_wheel(wheel_directory: str, config_settings: dict | None = None,
                metadata_directory: str | None = None) -> str:
    files = {path.as_posix(): path.read_bytes() for path in sources()}
    if note():
        files[f"{package()}/{note()}"] = f"{Path.cwd()}\n".encode()
    return write_wheel(wheel_directory, files)


def build_editable(wheel_directory: str, config_settings: dict | None = None,
                   metadata_directory: str | None = None) -> str:
    """File that names this folder, so that changes here count at once."""
    return write_wheel(wheel_directory, {f"{package()}.pth": f"{Path.cwd()}\n".encode()})


def build_sdist(sdist_directory: str, config_settings: dict | None = None) -> str:
    if note():
        raise SystemExit(f"{package()}: allowed: an installation from its folder, which has the programs that it "
                         "starts")
    base = f"{package()}-{project()['version']}"
    with tarfile.open(Path(sdist_directory) / f"{base}.tar.gz", "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for path in [Path("pyproject.toml"), Path(__file__).relative_to(Path.cwd()), *sources()]:
            archive.add(path, f"{base}/{path.as_posix()}")
        text = metadata().encode()
        entry = tarfile.TarInfo(f"{base}/PKG-INFO")
        entry.size = len(text)
        archive.addfile(entry, io.BytesIO(text))
    return f"{base}.tar.gz"
