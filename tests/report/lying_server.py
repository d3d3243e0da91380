#!/usr/bin/python3
"""lying_server.py PORT CERTIFICATE KEY WAY: a web server that answers everybody wrongly, in one of its ways."""

import socket
import ssl
import sys
import threading
import time

port, certificate, key, way = int(sys.argv[1]), *sys.argv[2:]
TAG = b'ETag: "one"\r\n'


def endless(send):
    send(b"HTTP/1.1 200 OK\r\n" + TAG + b"Transfer-Encoding: chunked\r\n\r\n")
    while True:
        send(b"10000\r\n" + b"x" * 65536 + b"\r\n")


def huge(send):
    send(b"HTTP/1.1 200 OK\r\n" + TAG + b"Content-Length: 9000000000\r\n\r\n" + b"x" * 1000)


def short(send):
    send(b"HTTP/1.1 200 OK\r\n" + TAG + b"Content-Length: 2000\r\n\r\n" + b"x" * 1000)


def header(send):
    send(b"HTTP/1.1 200 OK\r\n")
    while True:
        send(b"X-Header: " + b"x" * 1000 + b"\r\n")


def slow(send):
    send(b"HTTP/1.1 200 OK\r\n" + TAG + b"Content-Length: 2000\r\n\r\n")
    for _ in range(2000):
        send(b"x")
        time.sleep(1)


def silent(send):
    time.sleep(600)


def tagless(send):
    send(b"HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nxxx")


def elsewhere(send):
    send(b"HTTP/1.1 302 Found\r\nLocation: file:///etc/passwd\r\nContent-Length: 0\r\n\r\n")


def part(send):
    send(b"HTTP/1.1 206 Partial Content\r\n" + TAG + b"Content-Range: bytes 7-9/10\r\nContent-Length: 3\r\n\r\nxxx")


def empty(send):
    send(b"HTTP/1.1 200 OK\r\n" + TAG + b"Content-Length: 0\r\n\r\n")


def nonsense(send):
    send(b"\x00\xff" * 5000)


def missing(send):
    send(b"HTTP/1.1 404 Not Found\r\nContent-Length: 4\r\n\r\nnone")


def verbose(send):
    send(b"HTTP/1.1 404 Not Found\r\nContent-Length: 200000\r\n\r\n" + b"x" * 200000)


def answer(guest, context):
    try:
        with context.wrap_socket(guest, server_side=True) as talk:
            talk.recv(65536)
            globals()[way](talk.sendall)
    except OSError:
        pass


def main():
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate, key)
    with socket.create_server(("127.0.0.1", port)) as listening:
        while True:
            guest, _ = listening.accept()
            threading.Thread(target=answer, args=(guest, context), daemon=True).start()


main()
