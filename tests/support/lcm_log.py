"""LCM event logs and messages from Python, for tests: written from LCM's documentation, not from our C++."""
import re
import struct

_FORMATS = {"int8_t": "b", "boolean": "b", "byte": "B", "int16_t": "h", "int32_t": "i", "int64_t": "q",
            "float": "f", "double": "d"}
_MASK = (1 << 64) - 1


class Type:
    """A struct of a .lcm text whose members are primitives, strings and arrays of them."""

    def __init__(self, text):
        text = re.sub(r"//.*", "", text)
        self.name, body = re.search(r"struct\s+(\w+)\s*\{(.*)\}", text, re.S).groups()
        self.members = [(t, n, re.findall(r"\[(\w+)\]", d))
                        for t, n, d in re.findall(r"(\w+)\s+(\w+)((?:\[\w+\])*)\s*;", body)]
        value = 0x12345678

        def update(byte):
            nonlocal value
            signed = value - (1 << 64) if value >> 63 else value
            value = ((value << 8) ^ (signed >> 55)) + byte & _MASK

        def update_text(s):
            update(len(s))
            for c in s.encode():
                update(c)
        for type_name, name, sizes in self.members:
            update_text(name)
            update_text(type_name)
            update(len(sizes))
            for size in sizes:
                update(0 if size.isdigit() else 1)
                update_text(size)
        self.fingerprint = ((value << 1) + (value >> 63)) & _MASK

    def encode(self, **fields):
        out = struct.pack(">Q", self.fingerprint)
        for type_name, name, sizes in self.members:
            value = fields.get(name, "" if type_name == "string" else 0)
            for size in sizes:
                count = int(size) if size.isdigit() else fields.get(size, 0)
                value = list(fields.get(name, [0] * count))
                assert len(value) == count, name
            for v in value if sizes else [value]:
                if type_name == "string":
                    out += struct.pack(">i", len(v.encode()) + 1) + v.encode() + b"\0"
                else:
                    out += struct.pack(">" + _FORMATS[type_name], v)
        return out


def record(number, time_us, channel, data):
    """One event of a log."""
    name = channel.encode()
    return struct.pack(">Iqqii", 0xEDA1DA01, number, time_us, len(name), len(data)) + name + data


def records(blob):
    """(number, time_us, channel, data) of every event of an undamaged log."""
    at = 0
    while at < len(blob):
        sync, number, time_us, name_length, length = struct.unpack_from(">Iqqii", blob, at)
        assert sync == 0xEDA1DA01, at
        at += 28
        yield number, time_us, blob[at:at + name_length].decode(), blob[at + name_length:at + name_length + length]
        at += name_length + length
