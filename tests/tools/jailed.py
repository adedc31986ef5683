"""The attacks that tests/tools/jails.py compares jails by: small programs, past everything that is written in Python.

Each says `done(what)` where it succeeds. What only can be seen from outside (a process that was killed, a file that
is left) is looked for by jails.py after each of them, whatever it said. `P` is what there is to be reached.
"""

PRELUDE = """
import ctypes, fcntl, mmap, os, resource, signal, socket, struct, sys, time
libc = ctypes.CDLL(None, use_errno=True)
def ok(result):
    if result < 0: raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result
def call(number, *args):
    return ok(libc.syscall(ctypes.c_long(number), *[ctypes.c_long(a) if isinstance(a, int) else a for a in args]))
def children(number, work, last=3):
    for each in range(number):
        if os.fork() == 0:
            try:
                work()
                time.sleep(last)
            finally:
                os._exit(0)
"""

WRITTEN = "written = 0\ndef write(path, mode='ab'):\n    global written\n    written += open(path, mode).write(bytes(8_000_000))\n"
ATTACKS: dict[str, dict[str, str]] = {
    "files": {
        "reads another submission": "done(open(P['file']).read())",
        "reads it natively": "fd = ok(libc.open(P['file'].encode(), 0)); done(os.read(fd, 99).decode())",
        "reads it by a link": "os.symlink(P['file'], 'l'); done(open('l').read())",
        "lists its folder": "done(os.listdir(os.path.dirname(P['file'])))",
        "asks whether it exists": "done(os.stat(P['file']).st_size)",
        "alters it": "open(P['file'], 'a').write('x'); done('altered')",
        "removes it": "os.remove(P['file']); done('removed')",
        "opens its rights": "os.chmod(P['file'], 0o777); done('changed')",
        "plants a file": "open(P['open'] + '/planted', 'w').write('x'); done('planted')",
        "reads the machine's accounts": "done(len(open('/etc/shadow' if P['root'] else '/etc/passwd').read()) and 'read')"
        " if P['name'] in open('/etc/hostname').read() else None",
        "alters a library": "open(P['library'], 'a').write('x'); done('altered')",
        "closes a library by its descriptor": "os.fchmod(os.open(P['library'], 0), 0o600); done('changed')",
        "dates a library by its descriptor": "os.utime(os.open(P['library'], 0), (0, 0)); done('changed')",
        "gives a library attributes by its descriptor": (
            "call(190, os.open(P['library'], 0), b'user.x', b'x', 1, 0); done('changed')"
        ),
        "flags a library by its descriptor": (
            "fcntl.ioctl(os.open(P['library'], 0), 0x40086602, struct.pack('l', 0x40)); done('changed')"
        ),
        "flags a library by its path": (
            "call(469, -100, P['library'].encode(), struct.pack('QIIII', 0x80, 0, 0, 0, 0), 24, 0); done('changed')"
        ),
        "takes a lease of a library": (
            "fcntl.fcntl(os.open(P['library'], 0), fcntl.F_SETLEASE, fcntl.F_RDLCK); done('whoever writes it waits')"
        ),
        "makes a device": (
            "os.mknod('disk', 0o660 | 0o060000, os.makedev(7, 0)); os.open('disk', 0); done('opened a disk')"
        ),
        "opens the machine's devices": (
            "seen = [n for n in os.listdir('/dev') if n.startswith(('vd', 'sd', 'loop', 'mem', 'kvm', 'fuse', 'kmsg'))]\n"
            "seen = [n for n in seen if os.access('/dev/' + n, 4)]\nif seen: done(seen)"
        ),
        "leaves files behind": "os.mkdir('qdot-left'); open('qdot-left/qdot-left', 'w').write('x')",
    },
    "disk": {
        "a large file": WRITTEN + "for i in range(32): write('x')\ndone('wrote 256 MB')",
        "many files": WRITTEN + "for i in range(32): write(str(i))\ndone('wrote 256 MB')",
        "files without names": WRITTEN + "k = []\nfor i in range(32):\n    k.append(open('n', 'wb', 0)); os.unlink('n')\n"
        "    k[-1].write(bytes(8_000_000))\ndone('wrote 256 MB')",
        "empty files": "for i in range(20_000): open(str(i), 'w').close()\ndone('made 20,000 files')",
        "other places": WRITTEN + "for d in ('/', '/dev', '/dev/shm', '/run', '/var/tmp'):\n    n = f'{d}/qdot-left'\n"
        "    try:\n        for i in range(32): write(n); f = open(n); os.unlink(n); k = globals().setdefault('k', []); k.append(f)\n"
        "    except OSError: pass\n    if written > 200_000_000: done('wrote 256 MB'); break",
        "other places, left": "open('/dev/shm/qdot-left', 'w').write('x')",
        "core dumps": "resource.setrlimit(resource.RLIMIT_CORE, (-1, -1)); os.abort()",
    },
    "network": {
        "connects": "socket.create_connection(('127.0.0.1', P['port']), 2); done('connected')",
        "sends a datagram": "socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b'x', ('127.0.0.1', P['udp']))",
        "an abstract socket": "socket.socket(socket.AF_UNIX).connect(P['abstract']); done('connected')",
        "a socket in a folder": "socket.socket(socket.AF_UNIX).connect(P['socket']); done('connected')",
        "lists the machine's interfaces": (
            "names = [n for _, n in socket.if_nameindex() if n != 'lo']\nif names: done(names)"
        ),
    },
    "processes": {
        "signals the grader": "os.kill(P['pid'], 0)\nif os.getpgid(P['pid']) == P['group']: os.kill(P['pid'], 9); done('killed')",
        "by a descriptor's owner": (
            "r, w = os.pipe(); fcntl.fcntl(r, fcntl.F_SETOWN, P['pid']); fcntl.fcntl(r, fcntl.F_SETSIG, 9)\n"
            "fcntl.fcntl(r, fcntl.F_SETFL, os.O_ASYNC); os.write(w, b'x'); time.sleep(0.2)"
        ),
        "traces the grader": "ok(libc.ptrace(0x4206, P['pid'], 0, 0)); done('traced')",
        "reads its memory": (
            "b = ctypes.create_string_buffer(16); v = struct.pack('QQ', ctypes.addressof(b), 16)\n"
            "call(310, P['pid'], v, 1, struct.pack('QQ', P['address'], 16), 1, 0)\ndone(b.raw)"
        ),
        "reads its memory by /proc": "f = open('/proc/%d/mem' % P['pid'], 'rb', 0); f.seek(P['address']); done(f.read(16))",
        "reads its environment": "e = open('/proc/%d/environ' % P['pid']).read()\nif 'CANARY' in e: done(e)",
        "inherits the grader's environment": "if 'CANARY' in repr(dict(os.environ)): done('read')",
        "reads command lines": (
            "seen = [open('/proc/%s/cmdline' % p).read() for p in os.listdir('/proc') if p.isdigit()]\n"
            "if any(P['mark'][::-1] in s for s in seen): done('read')"
        ),
        "asks for its group": "if os.getpgid(P['pid']) == P['group']: done(P['group'])",
        "asks for its processor time": "done(time.clock_gettime(~P['pid'] << 3 | 2)) if P['pid'] > 9 else None",
        "slows it down": "os.setpriority(os.PRIO_PROCESS, P['pid'], 19); done('slowed')",
        "limits it": "resource.prlimit(P['pid'], resource.RLIMIT_NOFILE, (50, 50)); done('limited')",
        "chooses its processor": "os.sched_setaffinity(P['pid'], [0]); done('bound')",
        "leaves a process behind": (
            "if os.fork() == 0:\n    os.setsid(); libc.prctl(15, b'qdot-left', 0, 0, 0)\n"
            "    if os.fork() == 0: time.sleep(3)\n    os._exit(0)\nos.wait()"
        ),
        "forks 200 times": "children(200, lambda: None)\ndone('200 processes')",
        "starts 1,000 threads": (
            "import threading\nfor i in range(1000): threading.Thread(target=time.sleep, args=(1,), daemon=True).start()\n"
            "done('1,000 threads')"
        ),
    },
    "memory": {
        "takes 1.5 GB": "m = mmap.mmap(-1, 1_500_000_000); m[::4096] = bytes(len(m[::4096])); done('1.5 GB')",
        "takes 2.4 GB in processes": (
            "def work():\n    global m\n    m = mmap.mmap(-1, 200_000_000); m[::4096] = bytes(len(m[::4096]))\n"
            "children(12, work); done('2.4 GB')"
        ),
        "takes files without a place": (
            "k = [os.memfd_create(str(i)) for i in range(50)]\nfor f in k: os.write(f, bytes(10_000_000))\ndone('500 MB')"
        ),
        "raises its limits": (
            "for l in (resource.RLIMIT_AS, resource.RLIMIT_CPU): resource.setrlimit(l, (1 << 41, 1 << 41))\ndone('raised')"
        ),
        "shared memory (System V), left": "ok(libc.shmget(0x71646f74, ctypes.c_size_t(4096), 0o1666))",
        "message queues (System V), left": "ok(libc.msgget(0x71646f74, 0o1666))",
        "semaphores (System V), left": "ok(libc.semget(0x71646f74, 1, 0o1666))",
        "message queues (POSIX), left": "call(240, b'qdot-left', 0o102, 0o666, None)",
        "keys, left": (
            "last = None\nfor ring in (-3, -4, -5):\n    try: call(248, b'user', b'qdot-left', b'x', 1, ring)\n"
            "    except OSError as error: last = error\nif last: raise last"
        ),
        "takes 20,000 timers": (
            "t = ctypes.c_int()\nfor i in range(20_000): ok(libc.timer_create(1, None, ctypes.byref(t)))\ndone('20,000 timers')"
        ),
        "takes places for asynchronous input": (
            "t = ctypes.c_ulong()\ncall(206, 5000, ctypes.byref(t)); done('5,000 of the 65,536 of the machine')"
        ),
    },
    "time": {
        "computes without end": "signal.signal(signal.SIGXCPU, signal.SIG_IGN)\nwhile True: pass",
        "sleeps without end": "for s in range(1, 64):\n    try: signal.signal(s, signal.SIG_IGN)\n    except (OSError, ValueError): pass\n"
        "while True: time.sleep(1)",
        "takes precedence": "os.nice(-5); done('took')",
        "is served in real time": "os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1)); done('took')",
    },
    "privileges": {
        "becomes root of a namespace": "ok(libc.unshare(0x10000000)); done('became')",
        "mounts": (
            "try: ok(libc.unshare(0x10020000))\nexcept OSError: ok(libc.unshare(0x20000))\n"
            "ok(libc.mount(b'x', b'/', b'tmpfs', 0, None)); done('mounted')"
        ),
        "changes its root": "os.chroot('.'); done('changed')",
        "becomes root": "os.setuid(0); open('x', 'w').close(); os.chown('x', 1, 1); done('became')",
        "starts a program of root's": (
            "from subprocess import PIPE, Popen\np = Popen(['/usr/bin/su', 'root'], stdin=PIPE, stdout=PIPE, stderr=PIPE)\n"
            "time.sleep(0.3)\nuids = [l for l in open('/proc/%d/status' % p.pid) if l.startswith('Uid')][0].split()[1:]\n"
            "p.stdin.close()\nif uids[1] == '0': done('it ran as root')"
        ),
        "userfaultfd": "call(323, 1); done('had it')",
        "io_uring": "call(425, 4, ctypes.create_string_buffer(120)); done('had it')",
        "bpf": "call(321, 0, struct.pack('IIIIIIIIIIIIIIIIII', 2, 4, 4, 1, *[0] * 14), 72); done('had it')",
        "perf_event_open": (
            "a = bytearray(128); struct.pack_into('IIQ', a, 0, 1, 128, 0); struct.pack_into('Q', a, 40, 0x60)\n"
            "call(298, bytes(a), 0, -1, -1, 0); done('had it')"
        ),
        "modify_ldt": "call(154, 1, struct.pack('IIII', 0, 0, 0xfffff, 0x51), 16); done('had it')",
        "personality": "call(135, 0x0040000); done('had it')",
        "file handles": (
            "h = ctypes.create_string_buffer(struct.pack('Ii', 64, 0), 80); i = ctypes.c_int()\n"
            "call(303, -100, P['library'].encode(), h, ctypes.byref(i), 0)\n"
            "call(304, os.open('.', 0), h, 0); done('opened past all folders')"
        ),
        "the kernel's messages": "call(103, 3, ctypes.create_string_buffer(999), 999); done('read')",
    },
}  # fmt: skip
"""By what they are against; system calls by their numbers on x86_64."""
