#!/usr/bin/python3
"""Reads the datagrams of one OpenTrackIO sample (files, in order), checks header, checksum and JSON schema, and prints the
sample's JSON: a reader that shares nothing with the sender. Exit 1 and a sentence where something is wrong.

    open_track_io_reader.py SCHEMA DATAGRAM...
"""
import json
import struct
import sys

import jsonschema


def fail(what):
    sys.exit(what)


payload = b""
sequences = set()
for at, path in enumerate(sys.argv[2:]):
    data = open(path, "rb").read()
    if len(data) > 1472:
        fail("%s: %d bytes do not fit an Ethernet frame" % (path, len(data)))
    mark, _, encoding, sequence, offset, last_and_length, checksum = struct.unpack("!4sBBHIHH", data[:16])
    body = data[16:]
    if mark != b"OTrk" or encoding != 1:
        fail("%s: not a JSON packet of OpenTrackIO" % path)
    a = b = 0
    for byte in data[:14] + body:
        a = (a + byte) % 256
        b = (b + a) % 256
    if checksum != b * 256 + a:
        fail("%s: checksum %04x, not %04x" % (path, checksum, b * 256 + a))
    if last_and_length % 32768 != len(body):
        fail("%s: length %d, not %d" % (path, last_and_length % 32768, len(body)))
    if (last_and_length >= 32768) != (at == len(sys.argv) - 3):
        fail("%s: last segment flag" % path)
    if offset != len(payload):
        fail("%s: offset %d, not %d" % (path, offset, len(payload)))
    payload += body
    sequences.add(sequence)
if len(sequences) != 1:
    fail("the sequence number changes within a sample")
sample = json.loads(payload)
schema = json.load(open(sys.argv[1]))
jsonschema.Draft202012Validator.check_schema(schema)
errors = list(jsonschema.Draft202012Validator(schema).iter_errors(sample))
if errors:
    fail("; ".join("%s: %s" % ("/".join(map(str, e.path)), e.message) for e in errors))
print(json.dumps(sample))
