"""A reader of MCAP files (version 0 of the format, uncompressed or zstd), written from its specification and from nothing of bipc.

`Mcap(bytes)` checks what a strict reader checks: magic, lengths, CRCs, that channels stand before their messages, and that summary, statistics
and every index say what is there. `messages` are (topic, instant, data) in the order of the file; `by_index()` reads them again
through footer, chunk indexes and message indexes.
"""
import ctypes
import ctypes.util
import json
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
(HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, _, _, STATISTICS, _, _, SUMMARY_OFFSET, DATA_END) = range(1, 16)


class Fields:
    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, size):
        assert self.at + size <= len(self.data), "a field goes beyond its record"
        self.at += size
        return int.from_bytes(self.data[self.at - size:self.at], "little")

    def bytes(self, size_of_length):
        size = self.number(size_of_length)
        assert self.at + size <= len(self.data), "a field goes beyond its record"
        self.at += size
        return self.data[self.at - size:self.at]

    def text(self):
        return self.bytes(4).decode("utf-8")

    def pairs(self, key, value):
        inner = Fields(self.bytes(4))
        out = []
        while inner.at < len(inner.data):
            out.append((inner.text() if key == "text" else inner.number(key), inner.text() if value == "text" else inner.number(value)))
        return out

    def rest(self):
        out, self.at = self.data[self.at:], len(self.data)
        return out

    def done(self):
        assert self.at == len(self.data), "a record has more than its fields"


def records(data, start, end):
    """(opcode, offset, content, offset behind) of each."""
    at = start
    while at < end:
        opcode, size = data[at], struct.unpack_from("<Q", data, at + 1)[0]
        assert at + 9 + size <= end, "a record goes beyond the end"
        yield opcode, at, data[at + 9:at + 9 + size], at + 9 + size
        at += 9 + size


def unpacked_bytes(compression, packed, size):
    """A chunk's records. zstd: by the system's library."""
    if compression == "":
        return packed
    assert compression == "zstd", compression
    zstd = ctypes.CDLL(ctypes.util.find_library("zstd"))
    zstd.ZSTD_decompress.restype = ctypes.c_size_t
    zstd.ZSTD_decompress.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    out = ctypes.create_string_buffer(size)
    assert zstd.ZSTD_decompress(out, size, packed, len(packed)) == size, "a chunk that cannot be decompressed"
    return out.raw


class Mcap:
    def __init__(self, data):
        self.data, self.schemas, self.channels, self.messages, self.chunks, self.counts = data, {}, {}, [], [], {}
        assert data.startswith(MAGIC) and data.endswith(MAGIC), "no magic"
        end, seen = len(data) - len(MAGIC), []
        self.indexes, where = {}, None
        for opcode, at, content, behind in records(data, len(MAGIC), end):
            seen.append(opcode)
            if opcode == DATA_END:
                f = Fields(content)
                assert f.number(4) in (0, zlib.crc32(data[:at])), "CRC of the data section"
                f.done()
                where = behind
                break
            self.data_record(opcode, at, content)
        assert seen[0] == HEADER and where is not None
        self.summary(where, end)

    def schema(self, content):
        f = Fields(content)
        row = (f.number(2), f.text(), f.text(), f.bytes(4))
        f.done()
        assert row[0] != 0 and row[2] == "jsonschema" and json.loads(row[3])["type"] == "object"
        return row[0], row[1:]

    def channel(self, content):
        f = Fields(content)
        number, schema, topic, encoding, metadata = f.number(2), f.number(2), f.text(), f.text(), f.pairs("text", "text")
        f.done()
        assert encoding == "json" and schema in self.schemas
        return number, (topic, schema, dict(metadata))

    def message(self, content):
        f = Fields(content)
        channel, sequence, log, publish = f.number(2), f.number(4), f.number(8), f.number(8)
        assert channel in self.channels and log == publish
        return channel, sequence, log, json.loads(f.rest())

    def data_record(self, opcode, at, content):
        f = Fields(content)
        if opcode == HEADER:
            f.text(), f.text()
            f.done()
        elif opcode == SCHEMA:
            number, row = self.schema(content)
            self.schemas[number] = row
        elif opcode == CHANNEL:
            number, row = self.channel(content)
            self.channels[number] = row
        elif opcode == CHUNK:
            first, last, size, crc, compression, inner = f.number(8), f.number(8), f.number(8), f.number(4), f.text(), f.bytes(8)
            f.done()
            packed = len(inner)
            inner = unpacked_bytes(compression, inner, size)
            assert len(inner) == size and zlib.crc32(inner) == crc
            found = {}
            for o, offset, c, _ in records(inner, 0, len(inner)):
                if o == MESSAGE:
                    channel, sequence, log, data = self.message(c)
                    assert first <= log <= last
                    assert sequence == self.counts.get(channel, 0), "sequence numbers"
                    self.counts[channel] = sequence + 1
                    found.setdefault(channel, []).append((log, offset))
                    self.messages.append((self.channels[channel][0], log, data))
                else:
                    assert o in (SCHEMA, CHANNEL)
                    self.data_record(o, None, c)
            self.chunks.append({"at": at, "size": 9 + len(content), "first": first, "last": last, "found": found, "index": {}, "inner": inner, "packed": packed, "compression": compression})
        elif opcode == MESSAGE_INDEX:
            channel, rows = f.number(2), f.pairs(8, 8)
            f.done()
            self.chunks[-1]["index"][channel] = at
            assert rows == self.chunks[-1]["found"][channel], "an index of messages"
        else:
            raise AssertionError(f"record {opcode} among the data")

    def summary(self, start, end):
        groups, chunk_rows, offsets = {}, [], []
        schemas, channels = {}, {}
        for opcode, at, content, behind in records(self.data, start, end):
            f = Fields(content)
            if opcode == SCHEMA:
                schemas.update([self.schema(content)])
            elif opcode == CHANNEL:
                channels.update([self.channel(content)])
            elif opcode == STATISTICS:
                counts = [f.number(n) for n in (8, 2, 4, 4, 4, 4, 8, 8)]
                assert counts[:6] == [len(self.messages), len(self.schemas), len(self.channels), 0, 0, len(self.chunks)], counts
                instants = [instant for _, instant, _ in self.messages]
                assert counts[6:] == [min(instants), max(instants)]
                by_channel = {}
                for topic, _, _ in self.messages:
                    by_channel[topic] = by_channel.get(topic, 0) + 1
                assert {self.channels[c][0]: n for c, n in f.pairs(2, 8)} == by_channel
                f.done()
            elif opcode == CHUNK_INDEX:
                first, last, where, size, index = f.number(8), f.number(8), f.number(8), f.number(8), dict(f.pairs(2, 8))
                index_size, compression, packed, unpacked = f.number(8), f.text(), f.number(8), f.number(8)
                f.done()
                chunk = self.chunks[len(chunk_rows)]
                assert (first, last, where, size, index) == tuple(chunk[k] for k in ("first", "last", "at", "size", "index"))
                assert (compression, packed, unpacked) == (chunk["compression"], chunk["packed"], len(chunk["inner"]))
                assert index_size == sum(9 + struct.unpack_from("<Q", self.data, i + 1)[0] for i in index.values())
                chunk_rows.append((where, index))
            elif opcode == SUMMARY_OFFSET:
                offsets.append((f.number(1), f.number(8), f.number(8)))
                f.done()
            elif opcode == FOOTER:
                summary_start, offset_start, crc = f.number(8), f.number(8), f.number(4)
                f.done()
                assert behind == end and summary_start == start and offset_start == groups[SUMMARY_OFFSET][0]
                assert crc in (0, zlib.crc32(self.data[start:end - 4])), "CRC of the summary"
                assert offsets == [(o, *groups[o]) for o in groups if o != SUMMARY_OFFSET], "offsets of the summary"
            else:
                raise AssertionError(f"record {opcode} in the summary")
            if opcode != FOOTER:
                begun = groups.setdefault(opcode, (at, 0))
                groups[opcode] = (begun[0], begun[1] + behind - at)
        assert schemas == self.schemas and channels == self.channels and len(chunk_rows) == len(self.chunks)
        self.chunk_rows = chunk_rows

    def by_index(self):
        """All messages by topic, found through the indexes alone."""
        out = {}
        for where, index in self.chunk_rows:
            f = Fields(self.data[where + 9:])
            size = [f.number(8), f.number(8), f.number(8)][2]
            f.number(4)
            inner = unpacked_bytes(f.text(), f.bytes(8), size)
            for channel, at in index.items():
                rows = Fields(self.data[at + 9:at + 9 + struct.unpack_from("<Q", self.data, at + 1)[0]])
                assert rows.number(2) == channel
                for log, offset in rows.pairs(8, 8):
                    size = struct.unpack_from("<Q", inner, offset + 1)[0]
                    assert inner[offset] == MESSAGE
                    got, _, when, data = self.message(inner[offset + 9:offset + 9 + size])
                    assert got == channel and when == log
                    out.setdefault(self.channels[channel][0], []).append((log, data))
        return out
