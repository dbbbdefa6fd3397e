"""A run's own authorities, and the identities that they issue.

There are two of them. The identity authority says who somebody is, the permissions authority what
somebody may do. With a single one each identity could sign permissions of its own, for whatever is
issued by the authority of permissions counts as its word. For the same reason the second one's
certificate can issue nothing: it only signs documents."""

import datetime
import os
import shutil
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_pem_private_key,
    pkcs7,
)
from cryptography.x509.oid import NameOID

import roles

# Of one identity, in its folder; SROS 2 calls them the same. The last is there once an identity
# was revoked.
KEY, CERTIFICATE = "key.pem", "cert.pem"
IDENTITY_CA, PERMISSIONS_CA = "identity_ca.cert.pem", "permissions_ca.cert.pem"
GOVERNANCE, PERMISSIONS = "governance.p7s", "permissions.p7s"
REVOKED = "crl.pem"

FOLDER = "authority"
STAGED = f".{FOLDER}"  # what a run that was stopped may leave
YEARS = datetime.timedelta(days=3650)
DAY = datetime.timedelta(days=1)  # clocks differ, and permissions are in local time


class Refused(Exception):
    """A request that cannot be done; says why."""


def _write(path, data, secret=False):
    """Whole or not at all; a secret is never readable by others."""
    staged = path.with_name(path.name + ".new")
    staged.unlink(missing_ok=True)
    handle = os.open(staged, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600 if secret else 0o644)
    with os.fdopen(handle, "wb") as file:
        file.write(data)
    staged.replace(path)


def _pem(key):
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def _name(run, common_name):
    return x509.Name(
        [
            x509.NameAttribute(NameOID.ORGANIZATION_NAME, run),
            x509.NameAttribute(NameOID.COMMON_NAME, common_name),
        ]
    )


def _usage(**allowed):
    kinds = (
        *("digital_signature", "content_commitment", "key_encipherment", "data_encipherment"),
        *("key_agreement", "key_cert_sign", "crl_sign", "encipher_only", "decipher_only"),
    )
    return x509.KeyUsage(**{kind: allowed.get(kind, False) for kind in kinds})


def _certificate(subject, key, issuer, issuer_key, days, constraints, usage):
    now = datetime.datetime.utcnow()
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - DAY)
        .not_valid_after(now + days)
        .add_extension(constraints, critical=True)
        .add_extension(usage, critical=True)
        .sign(issuer_key, hashes.SHA256())
    )


class Signer:
    """A key with its self-signed certificate."""

    def __init__(self, key, certificate):
        self.key, self.certificate = key, certificate

    @classmethod
    def make(cls, run, title, constraints, usage):
        key, name = ec.generate_private_key(ec.SECP256R1()), _name(run, title)
        return cls(key, _certificate(name, key, name, key, YEARS, constraints, usage))

    @classmethod
    def load(cls, folder, title):
        key = load_pem_private_key((folder / f"{title}.key.pem").read_bytes(), None)
        pem = (folder / f"{title}.cert.pem").read_bytes()
        return cls(key, x509.load_pem_x509_certificate(pem))

    def save(self, folder, title):
        _write(folder / f"{title}.key.pem", _pem(self.key), secret=True)
        _write(folder / f"{title}.cert.pem", self.pem())

    def pem(self):
        return self.certificate.public_bytes(Encoding.PEM)

    def sign(self, text):
        """@return `text` as a signed document of DDS-Security: S/MIME, readable as it is."""
        return (
            pkcs7.PKCS7SignatureBuilder()
            .set_data(text.encode())
            .add_signer(self.certificate, self.key, hashes.SHA256())
            .sign(
                Encoding.SMIME, [pkcs7.PKCS7Options.Text, pkcs7.PKCS7Options.DetachedSignature]
            )
        )


class Authority:
    """Both authorities of the run whose credentials are in `folder`."""

    def __init__(self, folder, identity, permissions, run, domain):
        self.folder, self.run, self.domain = Path(folder), run, domain
        self._identity, self._permissions = identity, permissions

    @classmethod
    def make(cls, folder, run, domain):
        """New ones; nothing is written before save()."""
        identity = Signer.make(
            run,
            f"metronome identities, domain {domain}",
            x509.BasicConstraints(ca=True, path_length=0),
            _usage(key_cert_sign=True, crl_sign=True),
        )
        permissions = Signer.make(
            run,
            f"metronome permissions, domain {domain}",
            x509.BasicConstraints(ca=False, path_length=None),
            _usage(digital_signature=True),
        )
        return cls(folder, identity, permissions, run, domain)

    @classmethod
    def load(cls, folder):
        """@throws Refused if a file is missing or broken."""
        at = Path(folder) / FOLDER
        try:
            identity = Signer.load(at, "identity_ca")
            permissions = Signer.load(at, "permissions_ca")
        except (OSError, ValueError) as error:
            raise Refused(f"cannot read the authorities in {at}: {error}") from None
        subject = identity.certificate.subject
        run = subject.get_attributes_for_oid(NameOID.ORGANIZATION_NAME)[0].value
        title = subject.get_attributes_for_oid(NameOID.COMMON_NAME)[0].value
        return cls(folder, identity, permissions, run, int(title.rsplit(" ", 1)[1]))

    def save(self):
        """All of a new authority, or nothing: half of one could not be gone on with."""
        staged = self.folder / STAGED
        shutil.rmtree(staged, ignore_errors=True)
        (staged / "issued").mkdir(parents=True, mode=0o700)
        staged.chmod(0o700)
        self._identity.save(staged, "identity_ca")
        self._permissions.save(staged, "permissions_ca")
        staged.rename(self.folder / FOLDER)

    def issue(self, name, days):
        """A new key, certificate and permissions in folder NAME; what was there is replaced. The
        certificate goes first and comes last: an identity without one is not whole.
        @param days  a timedelta: how long they are good for."""
        key, subject = ec.generate_private_key(ec.SECP256R1()), _name(self.run, name)
        certificate = _certificate(
            subject,
            key,
            self._identity.certificate.subject,
            self._identity.key,
            days,
            x509.BasicConstraints(ca=False, path_length=None),
            _usage(digital_signature=True),
        )
        begin, end = certificate.not_valid_before - DAY, certificate.not_valid_after + DAY
        document = roles.permissions(
            name, subject.rfc4514_string(), self.run, self.domain, begin, end
        )
        pem = certificate.public_bytes(Encoding.PEM)
        issued = self.folder / FOLDER / "issued" / f"{certificate.serial_number:x}.pem"
        _write(issued, pem)  # first: what is not listed cannot be revoked
        at = self.folder / name
        at.mkdir(parents=True, exist_ok=True)
        (at / CERTIFICATE).unlink(missing_ok=True)
        _write(at / KEY, _pem(key), secret=True)
        _write(at / IDENTITY_CA, self._identity.pem())
        _write(at / PERMISSIONS_CA, self._permissions.pem())
        _write(at / GOVERNANCE, self._permissions.sign(roles.governance(self.domain)))
        _write(at / PERMISSIONS, self._permissions.sign(document))
        revoked = self.folder / FOLDER / REVOKED
        if revoked.exists():
            _write(at / REVOKED, revoked.read_bytes())
        _write(at / CERTIFICATE, pem)

    def names(self):
        """Of the identities that have a folder, whole or not, sorted."""
        return sorted(path.parent.name for path in self.folder.glob(f"*/{KEY}"))

    def expires(self, name):
        """@return when the identity in folder NAME does, a datetime in UTC."""
        return _load(self.folder / name / CERTIFICATE).not_valid_after

    def is_good(self, name, when):
        """Whether folder NAME has an identity, a whole one, that is not expired. @param when  in UTC."""
        return (self.folder / name / CERTIFICATE).exists() and self.expires(name) > when

    def revoke(self, names):
        """Every identity that was ever issued to one of `names` is turned away by whoever has the
        new list; it goes into all folders. @throws Refused for a name never issued."""
        issued = [_load(path) for path in (self.folder / FOLDER / "issued").glob("*.pem")]
        unknown = set(names) - {_common_name(certificate) for certificate in issued}
        if unknown:
            raise Refused(f"nothing was issued to {', '.join(sorted(unknown))}: nothing is revoked")
        now, at = datetime.datetime.utcnow(), self.folder / FOLDER / REVOKED
        revoked = {c.serial_number for c in issued if _common_name(c) in names}
        if at.exists():
            revoked |= {entry.serial_number for entry in x509.load_pem_x509_crl(at.read_bytes())}
        builder = (
            x509.CertificateRevocationListBuilder()
            .issuer_name(self._identity.certificate.subject)
            .last_update(now - DAY)
            .next_update(self._identity.certificate.not_valid_after)
        )
        for serial in sorted(revoked):
            builder = builder.add_revoked_certificate(
                x509.RevokedCertificateBuilder().serial_number(serial).revocation_date(now).build()
            )
        pem = builder.sign(self._identity.key, hashes.SHA256()).public_bytes(Encoding.PEM)
        _write(at, pem)
        for name in self.names():
            _write(self.folder / name / REVOKED, pem)


def _load(path):
    return x509.load_pem_x509_certificate(path.read_bytes())


def _common_name(certificate):
    return certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)[0].value
