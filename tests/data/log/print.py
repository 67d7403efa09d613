"""Prints every value of a log as Python's `mcap` and `mcap-ros2-support` decode it.

Usage: print.py LOG.mcap > written.txt (in a venv with `pip install mcap mcap-ros2-support`).
A line is: topic, channel, bits of log time in seconds, bits of the value, and the value for reading people.
"""

import json
import struct
import sys

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


def bits(value):
    return struct.pack(">d", value).hex()


with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    for attachment in reader.iter_attachments():
        print("attachment", attachment.name, attachment.media_type)
    decoders = DecoderFactory()
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        if channel.message_encoding == "json":
            print(channel.topic, json.loads(message.data)["event"])
            continue
        row = decoders.decoder_for(channel.message_encoding, schema)(message.data)
        for name in row.__slots__:
            value = float(getattr(row, name))
            print(channel.topic, name, bits(message.log_time / 1e9), bits(value), repr(value))
