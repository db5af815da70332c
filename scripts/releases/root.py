# SPDX-License-Identifier: BSD-3-Clause
"""Minimal roots of releases of Debian and Ubuntu: made by debootstrap, kept, and entered with mounts of their own."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

KEYRINGS = Path("/usr/share/keyrings")
MARKER = ".gabion_root.json"
TREE = "gabion"  # where the checkout is in a root
NOT_TRACKED = {"build", "results"}  # of a checkout: what it makes


class ReleaseError(Exception):
    """The obstacle, and its remedy."""


@dataclass(frozen=True)
class Release:
    """Data of a release for debootstrap."""

    title: str
    mirror: str
    components: str
    keyring: str  # file in KEYRINGS
    package: str  # that has the keyring


DEBIAN = ("http://deb.debian.org/debian", "main", "debian-archive-keyring.gpg", "debian-archive-keyring")
UBUNTU = ("http://archive.ubuntu.com/ubuntu", "main,universe", "ubuntu-archive-keyring.gpg", "ubuntu-keyring")
RELEASES = {
    "bookworm": Release("Debian 12 (bookworm)", *DEBIAN),
    "trixie": Release("Debian 13 (trixie)", *DEBIAN),
    "noble": Release("Ubuntu 24.04 (noble)", *UBUNTU),
}

# Runs as the first process of its own process ids, in its own mounts: both end with it, however it ends.
# $1: the root; the rest: the command.
ENTER = """
set -e
mount -t proc proc "$1/proc"
mount --rbind /sys "$1/sys"
mount --bind /dev "$1/dev"
mount --bind /dev/pts "$1/dev/pts"
mount -t tmpfs -o mode=1777 tmpfs "$1/dev/shm"
mount -t tmpfs -o mode=1777 tmpfs "$1/tmp"
set +e
chroot "$@"
exit $?
"""


def isolated(*command: str, new_ids: bool) -> list[str]:
    """The words that run a command with mounts, and process ids, that end with it; it ends with this process."""
    ids = ["--pid", "--fork", "--kill-child"] if new_ids else []
    return ["setpriv", "--pdeathsig", "KILL", "unshare", "--mount", *ids, *command]


class Root:
    """A folder with a minimal system and a copy of the checkout."""

    def __init__(self, folder: Path, name: str) -> None:
        self.folder, self.name, self.release = folder, name, RELEASES[name]
        self.tree = folder / TREE

    @property
    def _marker(self) -> Path:
        return self.folder / MARKER

    def state(self) -> dict:
        """Record of earlier calls: release, whole, and the notes of the steps."""
        return json.loads(self._marker.read_text(encoding="utf-8"))

    def note(self, **facts: object) -> None:
        before = self.state() if self._marker.exists() else {"release": self.name}
        self._marker.write_text(json.dumps(before | facts, indent=1) + "\n", encoding="utf-8")

    def check(self) -> bool:
        """Whether the root is there.

        @raises ReleaseError  the folder is something else, or not whole
        """
        if not self.folder.exists() or (self.folder.is_dir() and not any(self.folder.iterdir())):
            return False
        if not self._marker.is_file():
            raise ReleaseError(f"{self.folder} is not empty and was not made by this command: "
                               "give another one with --root")
        found = self.state()
        if found["release"] != self.name:
            raise ReleaseError(f"{self.folder} is a root of {found['release']}: give another one with --root")
        if not found.get("whole"):
            raise ReleaseError(f"{self.folder}: debootstrap did not come to its end there; "
                               "remove the folder and start again")
        return True

    def make(self, mirror: str | None) -> None:
        """Make the root by debootstrap, in its present folder.

        @raises ReleaseError  debootstrap or the keys of the release are missing, or debootstrap failed
        """
        release = self.release
        keyring = KEYRINGS / release.keyring
        if shutil.which("debootstrap") is None:
            raise ReleaseError("debootstrap is missing: apt-get install debootstrap")
        if not keyring.exists():
            raise ReleaseError(f"{keyring} is missing, which checks what is fetched: apt-get install {release.package}")
        self.folder.mkdir(parents=True, exist_ok=True)
        self.note(whole=False)
        done = subprocess.run(isolated("debootstrap", "--variant=minbase", "--force-check-gpg", f"--keyring={keyring}",
                                       f"--components={release.components}", self.name, str(self.folder),
                                       mirror or release.mirror, new_ids=False), check=False)
        if done.returncode != 0:
            raise ReleaseError(f"debootstrap failed with exit code {done.returncode}; {self.folder} can be removed")
        self.note(whole=True)

    def copy_tree(self, source: Path) -> int:
        """Copy the tracked files of a checkout as they are now; equal files stay as they are, so that only what depends
        on others is built again. Returns the number of files that were written or removed."""
        listed = subprocess.run(["git", "-C", str(source), "ls-files", "-z"], capture_output=True, check=True).stdout
        tracked = {name for name in map(os.fsdecode, listed.split(b"\0")) if name and os.path.lexists(source / name)}
        changed = 0
        for name in sorted(tracked):
            changed += copied(source / name, self.tree / name)
        for name in present_files(self.tree):
            if name not in tracked:
                (self.tree / name).unlink()
                changed += 1
        return changed

    def command(self, *words: str) -> list[str]:
        """The words that run a command inside, in the copy of the checkout, with an environment of a fresh login."""
        names = ("http_proxy", "https_proxy")
        proxies = [f"{key}={value}" for key, value in os.environ.items() if key.lower() in names]
        inside = ["env", "-i", "HOME=/root", "PATH=/usr/bin:/bin:/usr/sbin:/sbin", "LANG=C.UTF-8", *proxies,
                  "sh", "-c", f'cd /{TREE} && exec "$@"', "sh"]
        return isolated("bash", "-c", ENTER, "bash", str(self.folder), *inside, *words, new_ids=True)

    def run(self, *words: str) -> int:
        """Run a command inside, with its output shown; its exit code."""
        return subprocess.run(self.command(*words), check=False).returncode

    def answer(self, *words: str) -> str:
        """Output of a command inside; empty: it failed."""
        done = subprocess.run(self.command(*words), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                              check=False)
        return done.stdout.strip() if done.returncode == 0 else ""


def copied(source: Path, target: Path) -> bool:
    """Whether a file had to be copied."""
    if source.is_symlink():
        if target.is_symlink() and os.readlink(target) == os.readlink(source):
            return False
    elif target.is_file() and not target.is_symlink() and target.stat().st_mode == source.stat().st_mode \
            and target.read_bytes() == source.read_bytes():
        return False
    target.parent.mkdir(parents=True, exist_ok=True)
    target.unlink(missing_ok=True)
    shutil.copy2(source, target, follow_symlinks=False)
    return True


def present_files(tree: Path) -> Iterator[str]:
    """Files of a copy, but those that it made itself."""
    for folder, folders, files in os.walk(tree):
        if Path(folder) == tree:
            folders[:] = [name for name in folders if name not in NOT_TRACKED]
        folders[:] = [name for name in folders if name != "__pycache__"]
        for name in files:
            yield str((Path(folder) / name).relative_to(tree))
        for name in folders:
            if (Path(folder) / name).is_symlink():
                yield str((Path(folder) / name).relative_to(tree))
