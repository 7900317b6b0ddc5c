"""The blocks of an MDF 4 file, walked along their links: lengths, links and cycle counts against the file.

ASAM MDF 4.x: an identification of 64 bytes, then blocks of a header of 24 bytes (name, length, number of links), links
of 8 bytes, and content. Data groups hold channel groups, these hold channels; records lie in data blocks.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import Final

from gearplay.files.measurements.refusing import DENSEST, MOST_NODES, damaged, quoted

IDENTIFICATION: Final = 64
HEADER: Final = 24
_BRANCHES: Final = {
    "HD": (0, 1, 3, 4),
    "DG": (0, 1),
    "CG": (0, 1),
    "CN": (0, 1),
    "FH": (0,),
    "AT": (0,),
    "EV": (0,),
}
_KINDS: Final = {
    ("HD", 0): "DG", ("HD", 1): "FH", ("HD", 3): "AT", ("HD", 4): "EV", ("DG", 0): "DG", ("DG", 1): "CG",
    ("CG", 0): "CG", ("CG", 1): "CN", ("CN", 0): "CN", ("FH", 0): "FH", ("AT", 0): "AT", ("EV", 0): "EV",
}  # fmt: skip
_VLSD_GROUP, _REMOTE_MASTER = 1 << 0, 1 << 3
_VIRTUAL: Final = (3, 6)
"""Kinds of channels without bytes in the record."""
_DEFLATE: Final = (0, 1)


@dataclass(frozen=True)
class Block:
    """One block: its name, place and length [bytes], its links."""

    name: str
    place: int
    length: int
    links: tuple[int, ...]

    @property
    def content(self) -> int:
        """Place of what follows the links [bytes]."""
        return self.place + HEADER + 8 * len(self.links)


class Walk:
    """Walks the blocks of one file and raises `MeasurementError` at the first that contradicts the file."""

    def __init__(self, path: Path, size: int, file: BufferedReader) -> None:
        self.path, self.size, self.file = path, size, file
        self.seen: set[int] = set()

    def check(self) -> None:
        """Walk the whole file."""
        self._identification()
        waiting = [self.block(IDENTIFICATION, "HD")]
        while waiting:
            block = waiting.pop()
            branches = _BRANCHES[block.name]
            for number, link in enumerate(block.links):
                if link and number not in branches:
                    self._reference(link)
                elif link:
                    name = _KINDS.get((block.name, number), "")
                    # the composition of a channel may be channels or an array
                    if (block.name, number) == ("CN", 1):
                        if self._reference(link).name != "CN":
                            continue
                        name = "CN"
                    waiting.append(self.branch(link, name))
            if block.name == "DG":
                self._data_group(block)

    def _identification(self) -> None:
        self.file.seek(0)
        head = self.file.read(IDENTIFICATION)
        if len(head) < IDENTIFICATION:
            raise damaged(self.path, f"must begin with an identification of 64 bytes, {len(head)} found")
        mark, version = head[:8], head[8:16].decode("latin-1").strip(" \0")
        flags = struct.unpack("<HH", head[60:64])
        if mark == b"UnFinMF " or any(flags):
            raise damaged(
                self.path, "was never finalised by its recorder", "Finalise it with the recorder's program"
            )
        if mark != b"MDF     " or not version.startswith("4."):
            raise damaged(self.path, f"must be MDF 4, version {quoted(version)} found", "Convert it to MDF 4")

    def block(self, place: int, name: str = "") -> Block:
        """Return the block at a place, which must lie in the file with all its length."""
        if place < IDENTIFICATION or place + HEADER > self.size:
            raise damaged(self.path, f"refers to a block {name} at byte {place}, the file has {self.size}")
        self.file.seek(place)
        mark, length, links = struct.unpack("<4s4xQQ", self.file.read(HEADER))
        found = mark[2:].decode("latin-1")
        if mark[:2] != b"##" or (name and found != name):
            raise damaged(self.path, f"must have a block {name or '##'} at byte {place}, {mark!r} found")
        if place + length > self.size or HEADER + 8 * links > length:
            left = self.size - place
            raise damaged(
                self.path, f"block {quoted(found)} declares {length} bytes and {links} links, {left} are left"
            )
        raw = self.file.read(8 * links)
        return Block(found, place, length, struct.unpack(f"<{links}Q", raw))

    def branch(self, place: int, name: str = "") -> Block:
        """Return a block that only one other may refer to; a second reference is a ring no reader leaves."""
        if place in self.seen:
            raise damaged(self.path, f"block {name} at byte {place} is linked twice: its links form a ring")
        if len(self.seen) >= MOST_NODES:
            raise damaged(self.path, f"has more than {MOST_NODES} blocks", "Export fewer channels")
        self.seen.add(place)
        return self.block(place, name)

    def _reference(self, place: int) -> Block:
        return self.block(place)

    def _integers(self, block: Block, layout: str) -> tuple[int, ...]:
        needed = struct.calcsize(layout)
        if block.content + needed > block.place + block.length:
            raise damaged(self.path, f"block {quoted(block.name)} at byte {block.place} is too short")
        self.file.seek(block.content)
        return struct.unpack(layout, self.file.read(needed))

    def _data_group(self, group: Block) -> None:
        """Compare the records that the channel groups declare with the bytes of the data blocks."""
        if len(group.links) < 4:
            raise damaged(
                self.path, f"block 'DG' at byte {group.place} has {len(group.links)} links, 4 are due"
            )
        (identifier,) = self._integers(group, "<B")
        declared, sized = 0, True
        for channels in self._chain(group.links[1], "CG"):
            if len(channels.links) < 6:
                rule = f"block 'CG' at byte {channels.place} has {len(channels.links)} links, 6 are due"
                raise damaged(self.path, rule)
            _, cycles, flags, _, _, width, extra = self._integers(channels, "<QQHHIII")
            sized = sized and not flags & (_VLSD_GROUP | _REMOTE_MASTER)
            declared += cycles * (identifier + width + extra)
            self._channels(channels.links[1], width + extra)
        held = self._held(group.links[2]) if group.links[2] else 0
        if held is not None and sized and held != declared:
            raise damaged(self.path, f"declares {declared} bytes of records and holds {held}")

    def _chain(self, place: int, name: str) -> Iterator[Block]:
        """Yield a block and those that its first link leads to, none twice."""
        passed: set[int] = set()
        while place:
            if place in passed:
                raise damaged(
                    self.path, f"block {name} at byte {place} is linked twice: its links form a ring"
                )
            passed.add(place)
            block = self.block(place, name)
            yield block
            place = block.links[0] if block.links else 0

    def _channels(self, place: int, width: int) -> None:
        """Check that each channel lies within its record."""
        for channel in self._chain(place, "CN"):
            kind, _, _, bit, byte, bits = self._integers(channel, "<BBBBII")
            end = byte + (bit + bits + 7) // 8
            if kind not in _VIRTUAL and end > width:
                raise damaged(self.path, f"a channel reaches to byte {end} of records of {width}")

    def _held(self, place: int) -> int | None:
        """Return the bytes of records in the data blocks from a place on; none where they are in columns."""
        total = 0
        waiting = [place]
        while waiting:
            block = self.branch(waiting.pop(), "")
            if block.name in ("DT", "DV"):
                total += block.length - HEADER
            elif block.name == "DZ":
                total += self._unpacked(block)
            elif block.name in ("DL", "HL"):
                waiting += [link for link in block.links if link]
            elif block.name == "LD":
                return None
            else:
                raise damaged(
                    self.path, f"must have data at byte {block.place}, block {quoted(block.name)} found"
                )
        return total

    def _unpacked(self, block: Block) -> int:
        """Return the bytes a packed block unpacks to, refused where no packing reaches that."""
        _, packing, _, _, unpacked, packed = self._integers(block, "<2sBBIQQ")
        if packed > block.place + block.length - block.content - HEADER:
            raise damaged(self.path, f"a packed block declares {packed} bytes, more than it has")
        if int(packing) in _DEFLATE and unpacked > DENSEST * packed + 64:
            raise damaged(self.path, f"a packed block of {packed} bytes declares to unpack to {unpacked}")
        if unpacked > DENSEST * self.size:
            raise damaged(self.path, f"a packed block declares to unpack to {unpacked} bytes")
        return int(unpacked)


def check_blocks(path: Path, size: int) -> None:
    """Raise `MeasurementError` where an MDF 4 file was never finalised or its blocks contradict it.

    Parameters
    ----------
    path
        The file.
    size
        Its size [bytes].

    """
    with path.open("rb") as file:
        Walk(path, size, file).check()
