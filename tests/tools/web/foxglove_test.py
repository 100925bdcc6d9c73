#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A client of Foxglove's protocol at slam-web while the simulated robot drives, and clients that break the protocol.
The peer is Debian's python3-websockets. Usage: in_namespace foxglove_test.py PROGRAMS SOURCE FOLDER"""
import asyncio
import base64
import json
import pathlib
import shutil
import struct
import sys
import time

sys.dont_write_bytecode = True  # into the sources

from browser import wait_until
from page_drive import TOKEN
from page_robot import Robot

try:
    import websockets
except ImportError:
    print("skipped: no python3-websockets")
    sys.exit(77)

URL = "ws://127.0.0.1:8080/"
PROTOCOLS = ["foxglove.sdk.v1", "foxglove.websocket.v1"]
SOON = 1.0  # [s] within which subscribed data comes
CONNECTIONS = 1000


def connect(url=URL, **options):
    return websockets.connect(url, subprotocols=options.pop("subprotocols", PROTOCOLS), max_size=None, **options)


async def greeting(client):
    """The channels by topic."""
    info = json.loads(await asyncio.wait_for(client.recv(), 5))
    assert info["op"] == "serverInfo" and info["name"] == "slamd" and info["sessionId"], info
    advertise = json.loads(await asyncio.wait_for(client.recv(), 5))
    assert advertise["op"] == "advertise", advertise
    for channel in advertise["channels"]:
        assert channel["encoding"] == "json" and channel["schemaEncoding"] == "jsonschema", channel
        assert json.loads(channel["schema"])["title"] == channel["schemaName"]
    return {channel["topic"]: channel for channel in advertise["channels"]}


async def newest(client, subscriptions, seconds):
    """The last message of each topic. subscriptions: topic by number"""
    messages, end = {}, time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        try:
            data = await asyncio.wait_for(client.recv(), left)
        except asyncio.TimeoutError:
            break
        assert isinstance(data, bytes), data
        opcode, number, received = struct.unpack_from("<BIQ", data)
        assert opcode == 1 and abs(received / 1e9 - time.time()) < 2, (opcode, received)
        messages[subscriptions[number]] = json.loads(data[13:])
    return messages


async def check_session():
    async with connect() as client:
        assert client.subprotocol == PROTOCOLS[0]
        channels = await greeting(client)
        topics = {10 + i: topic for i, topic in enumerate(channels)}
        await client.send(json.dumps({"op": "subscribe", "subscriptions": [
            {"id": number, "channelId": channels[topic]["id"]} for number, topic in topics.items()]}))
        messages = await newest(client, topics, SOON)
        for topic in ("/scan", "/map", "/pose", "/estimate", "/tf"):
            assert topic in messages, f"no {topic} within {SOON} s: {sorted(messages)}"
        assert len(base64.b64decode(messages["/scan"]["data"])) >= 100 * 16
        grid = messages["/map"]
        cells = base64.b64decode(grid["data"])
        assert len(cells) % grid["column_count"] == 0 and 0 in cells and 100 in cells
        assert len(messages["/estimate"]["covariance"]) == 9 and messages["/estimate"]["covariance"][0] > 0
        more = await newest(client, topics, 3)
        for topic in ("/wheels", "/imu", "/odometry", "/health"):
            assert topic in more, f"no {topic}: {sorted(more)}"
        await client.send(json.dumps({"op": "unsubscribe", "subscriptionIds": sorted(topics)[1:]}))
        await newest(client, topics, 1)  # what was on its way
        assert set(await newest(client, topics, 1)) == {topics[10]}
        await client.send("no JSON")
        while isinstance(status := await asyncio.wait_for(client.recv(), 5), bytes):
            pass
        assert json.loads(status)["op"] == "status" and json.loads(status)["level"] == 2, status


async def status_of(url=URL, **options):
    """Of the answer to a handshake that is refused."""
    try:
        async with connect(url, **options):
            return 101
    except websockets.InvalidStatusCode as refusal:
        return refusal.status_code


async def check_rights():
    assert await status_of(origin="https://stranger.example") == 403
    assert await status_of(origin="https://app.foxglove.dev") == 101
    assert await status_of(subprotocols=["other"]) == 400
    locked = "ws://127.0.0.1:8081/"
    assert await status_of(locked) == 401
    assert await status_of(locked + "?token=a-wrong-guess-of-it") == 401
    assert await status_of(locked + "?token=" + TOKEN) == 101


async def check_hostile(pid):
    async with connect() as good:
        channels = await greeting(good)
        await good.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": channels["/pose"]["id"]}]}))
        for hostile in (b"\x81\x03one", b"\x81\xfe\xff\xff" + b"mask" + bytes(65535), b"\xff" * 200):
            async with connect() as client:
                await greeting(client)
                client.transport.write(hostile)
                await asyncio.wait_for(client.wait_closed(), 5)
        before = memory_mb(pid)
        writers = []
        for _ in range(CONNECTIONS):
            try:
                writers.append((await asyncio.wait_for(asyncio.open_connection("127.0.0.1", 8080), 5))[1])
                writers[-1].write(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                                  b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
                                  b"Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n")
            except (OSError, asyncio.TimeoutError):
                pass
        await asyncio.sleep(2)
        grown = memory_mb(pid) - before
        print(f"{len(writers)} connections: {grown:.1f} MB more")
        assert grown < 20, grown
        for writer in writers:
            writer.close()
    async with connect() as client:
        assert "/pose" in await greeting(client)


def memory_mb(pid):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmRSS:")[1].split()[0]) / 1024


async def check_slow_reader(pid):
    """Who subscribes to all and never reads costs bounded memory, and is let go."""
    reader, writer = await asyncio.open_connection("127.0.0.1", 8080, limit=1024)
    before = memory_mb(pid)
    async with connect() as client:
        channels = await greeting(client)
        await client.send(json.dumps({"op": "subscribe", "subscriptions": [
            {"id": c["id"], "channelId": c["id"]} for c in channels.values()]}))
        client.transport.pause_reading()
        await asyncio.sleep(8)
        assert memory_mb(pid) - before < 20, memory_mb(pid) - before
    writer.close()


def main():
    programs, source, folder = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
    folder = folder / "foxglove"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    robot = Robot(programs, source, folder)
    locked = robot.start_locked_web()
    try:
        wait_until("slamd draws", has_map)
        asyncio.run(check_session())
        asyncio.run(check_rights())
        asyncio.run(check_slow_reader(robot.web.pid))
        asyncio.run(check_hostile(robot.web.pid))
        assert robot.web.poll() is None and locked.poll() is None
    finally:
        robot.stop()
        locked.kill()
        locked.wait()


def has_map():
    import urllib.request
    try:
        with urllib.request.urlopen("http://127.0.0.1:8080/api/v1/status", timeout=2) as answer:
            status = json.load(answer)
        return status["map"]["keyframes"] >= 5 and status["pose"] is not None
    except OSError:
        return False


if __name__ == "__main__":
    main()
