"""null_modem.py A B: two UNIX sockets whose clients hear each other, with as much in between as they care to send. QEMU's USB
serial adapter stops the whole machine until what it sends has been taken: its other end must not be QEMU itself."""
import selectors
import socket
import sys


def accepted(path):
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(path)
    listener.listen(1)
    return listener


listeners = [accepted(path) for path in sys.argv[1:3]]
print("ready", flush=True)
ends = [listener.accept()[0] for listener in listeners]
pending = {end: bytearray() for end in ends}  # to be sent to it
selector = selectors.DefaultSelector()
for end in ends:
    end.setblocking(False)
    selector.register(end, selectors.EVENT_READ)
while True:
    for key, events in selector.select():
        end, other = key.fileobj, ends[key.fileobj is ends[0]]
        try:
            if events & selectors.EVENT_READ:
                data = end.recv(65536)
                if not data:
                    sys.exit()
                pending[other] += data
            for side in ends:
                if pending[side]:
                    del pending[side][:side.send(pending[side])]
        except BlockingIOError:
            pass
        except OSError:
            sys.exit()
        for side in ends:
            selector.modify(side, selectors.EVENT_READ | (selectors.EVENT_WRITE if pending[side] else 0))
